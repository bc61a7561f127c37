//! Camera files: a camera as JSON that people write and the viewer prints.

use cullet::{Camera, Projection};
use glam::DVec3;
use serde::{Deserialize, Serialize, Serializer};

use crate::numbers::Number;

/// A camera file. Lengths in scene units, world space.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct CameraFile {
    eye: [Number; 3],
    target: [Number; 3],
    up: [Number; 3],
    /// Vertical field of view in degrees; exactly one of this and `ortho_height`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    yfov_deg: Option<Number>,
    /// Height of an orthographic view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    ortho_height: Option<Number>,
    znear: Number,
    /// `null` means infinite; leaving it out is an error.
    #[serde(deserialize_with = "Option::deserialize")]
    zfar: Option<Number>,
    /// Size of the picture in pixels; both or neither.
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "whole")]
    width: Option<Number>,
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "whole")]
    height: Option<Number>,
    /// Width over height where no picture is made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    aspect: Option<Number>,
}

impl CameraFile {
    /// Reads the text of a camera file. Unknown keys are passed over.
    pub fn parse(text: &str) -> Result<CameraFile, String> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let file: CameraFile = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if file.aspect.is_some_and(|Number(aspect)| !(aspect > 0.0 && aspect.is_finite())) {
            return Err("`aspect` must be finite and greater than 0".into());
        }
        file.size()?;
        Ok(file)
    }

    /// The camera, when there can be one.
    pub fn camera(&self) -> Result<Camera, String> {
        let near = self.znear.0;
        let far = self.zfar.map_or(f64::INFINITY, |far| far.0);
        let projection = match (self.yfov_deg, self.ortho_height) {
            (Some(Number(degrees)), None) => {
                Projection::Perspective { yfov: degrees.to_radians(), near, far }
            }
            (None, Some(Number(height))) => Projection::Orthographic { height, near, far },
            _ => return Err("give one of `yfov_deg` and `ortho_height`".into()),
        };
        let [eye, target, up] = [self.eye, self.target, self.up].map(vector);
        Camera::look_at(eye, target, up, projection).map_err(|error| error.to_string())
    }

    /// Width and height of the picture in pixels, when the file names them; both at least 1.
    pub fn size(&self) -> Result<Option<(u32, u32)>, String> {
        let pixels = |Number(n): Number| -> Result<u32, String> {
            let whole = n >= 1.0 && n <= f64::from(u32::MAX) && n.fract() == 0.0;
            whole.then_some(n as u32).ok_or_else(|| format!("{n} pixels are no picture size"))
        };
        match (self.width, self.height) {
            (Some(width), Some(height)) => Ok(Some((pixels(width)?, pixels(height)?))),
            (None, None) => Ok(None),
            _ => Err("give both `width` and `height`, or neither".into()),
        }
    }

    /// Width over height, when the file names it or a size.
    pub fn aspect(&self) -> Result<Option<f64>, String> {
        let of_size = self.size()?.map(|(width, height)| f64::from(width) / f64::from(height));
        Ok(of_size.or(self.aspect.map(|Number(aspect)| aspect)))
    }

    /// The file of a camera and a picture size; `None` for lenses it cannot express.
    pub fn of(camera: &Camera, width: u32, height: u32) -> Option<CameraFile> {
        let (yfov_deg, ortho_height, near, far) = match camera.projection() {
            Projection::Perspective { yfov, near, far } => {
                (Some(Number(yfov.to_degrees())), None, near, far)
            }
            Projection::Orthographic { height, near, far } => {
                (None, Some(Number(height)), near, far)
            }
            Projection::OffCentre(_) => return None,
        };
        Some(CameraFile {
            eye: camera.eye().to_array().map(Number),
            target: (camera.eye() - camera.back()).to_array().map(Number),
            up: camera.up().to_array().map(Number),
            yfov_deg,
            ortho_height,
            znear: Number(near),
            zfar: far.is_finite().then_some(Number(far)),
            width: Some(Number(width.into())),
            height: Some(Number(height.into())),
            aspect: None,
        })
    }
}

/// Pixels, without a decimal point.
fn whole<S: Serializer>(pixels: &Option<Number>, serializer: S) -> Result<S::Ok, S::Error> {
    pixels.map(|Number(n)| n as u32).serialize(serializer)
}

fn vector(numbers: [Number; 3]) -> DVec3 {
    DVec3::from_array(numbers.map(|number| number.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sound camera file with `change` put over it.
    fn file(change: &str) -> Result<(Camera, Option<(u32, u32)>), String> {
        let mut json: serde_json::Value = serde_json::from_str(
            r#"{"eye":[3,2,5], "target":[0,0,0], "up":[0,1,0], "yfov_deg":45, "znear":0.1,
                "zfar":100.0, "width":64, "height":48}"#,
        )
        .unwrap();
        let change: serde_json::Map<_, _> = serde_json::from_str(change).unwrap();
        for (key, value) in change {
            if value == "absent" {
                json.as_object_mut().unwrap().remove(&key);
            } else {
                json[key] = value;
            }
        }
        let file = CameraFile::parse(&json.to_string())?;
        Ok((file.camera()?, file.size()?))
    }

    #[test]
    fn every_spelling_of_the_contract() {
        let (plain, size) = file("{}").unwrap();
        assert_eq!(size, Some((64, 48)));
        let strings = r#"{"eye":["0x1.8p+1","2","5.0"], "yfov_deg":"45", "zfar":"1e2"}"#;
        assert_eq!(file(strings).unwrap().0, plain);
        let endless = file(r#"{"zfar":null}"#).unwrap().0;
        assert_eq!(file(r#"{"zfar":"inf"}"#).unwrap().0, endless);
        let ortho = file(r#"{"yfov_deg":"absent","ortho_height":2}"#).unwrap().0;
        assert!(matches!(ortho.projection(), Projection::Orthographic { .. }));
        let no_size = r#"{"width":"absent","height":"absent","aspect":1.5,"comment":"x"}"#;
        assert_eq!(file(no_size).unwrap().1, None);
    }

    #[test]
    fn everything_wrong_is_an_error() {
        for change in [
            r#"{"eye":["nan",0,0]}"#,
            r#"{"eye":[0,0,"inf"]}"#,
            r#"{"eye":[0,0]}"#,
            r#"{"eye":[0,0,"x"]}"#,
            r#"{"target":[3,2,5]}"#,
            r#"{"up":[0,0,0]}"#,
            r#"{"up":[3,2,5]}"#,
            r#"{"up":"absent"}"#,
            r#"{"yfov_deg":0}"#,
            r#"{"yfov_deg":180}"#,
            r#"{"yfov_deg":"nan"}"#,
            r#"{"yfov_deg":"absent"}"#,
            r#"{"ortho_height":2}"#,
            r#"{"yfov_deg":"absent","ortho_height":-1}"#,
            r#"{"yfov_deg":"absent","ortho_height":1,"zfar":null}"#,
            r#"{"znear":0}"#,
            r#"{"znear":"absent"}"#,
            r#"{"zfar":0.1}"#,
            r#"{"zfar":"nan"}"#,
            r#"{"zfar":"absent"}"#,
            r#"{"width":0}"#,
            r#"{"width":1.5}"#,
            r#"{"width":"absent"}"#,
            r#"{"aspect":0}"#,
        ] {
            assert!(file(change).is_err(), "{change}");
        }
        for text in ["", "[]", "{}", "{\"eye\":", "\0"] {
            assert!(CameraFile::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_camera_survives_its_file() {
        let camera = file(r#"{"zfar":null}"#).unwrap().0;
        let text = serde_json::to_string(&CameraFile::of(&camera, 64, 48).unwrap()).unwrap();
        assert!(text.ends_with(r#""width":64,"height":48}"#), "{text}");
        let again = CameraFile::parse(&text).unwrap();
        assert_eq!(again.size(), Ok(Some((64, 48))));
        assert!((again.camera().unwrap().eye() - camera.eye()).length() < 1e-12);
        assert!((again.camera().unwrap().back() - camera.back()).length() < 1e-12);
    }
}
