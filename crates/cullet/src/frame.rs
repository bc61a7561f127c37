//! The result: a set of pictures that agree with each other.

use glam::{Vec2, Vec3, Vec4};

use crate::{Pass, Passes};

/// A rectangle of pixels of the whole picture, origin top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Left border, px.
    pub x: u32,
    /// Upper border, px.
    pub y: u32,
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

/// The pictures of one frame. Each is row-major, top row first, `width * height` values, or
/// empty when its pass was not asked for. Buffers are kept from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// [`Pass::Color`]: sRGB-encoded RGB and linear, straight alpha.
    pub rgba8: Vec<[u8; 4]>,
    /// [`Pass::Linear`]: linear RGB and straight alpha.
    pub linear: Vec<Vec4>,
    /// [`Pass::Depth`]: distance along the view axis in scene units; infinity where nothing is.
    pub depth: Vec<f32>,
    /// [`Pass::Normal`]: unit, world space; 0 where nothing is.
    pub normal: Vec<Vec3>,
    /// [`Pass::Albedo`]: linear base colour; 0 where nothing is.
    pub albedo: Vec<Vec4>,
    /// [`Pass::Uv`]: first texture coordinates; 0 where nothing is or the mesh has none.
    pub uv: Vec<Vec2>,
    /// [`Pass::Position`]: world space; 0 where nothing is.
    pub position: Vec<Vec3>,
    /// [`Pass::Id`]: object number + 1; 0 where nothing is.
    pub id: Vec<u32>,
    /// [`Pass::Triangle`]: triangle number + 1; 0 where nothing is.
    pub triangle: Vec<u32>,
}

impl Frame {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether nothing has been drawn into it yet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Takes a size, and empties pictures for `passes` of a frame where nothing is.
    pub(crate) fn reset(&mut self, width: u32, height: u32, passes: Passes) {
        (self.width, self.height) = (width, height);
        let len = |pass| if passes.contains(pass) { self.len() } else { 0 };
        let (rgba8, linear, depth) = (len(Pass::Color), len(Pass::Linear), len(Pass::Depth));
        let (normal, albedo, uv) = (len(Pass::Normal), len(Pass::Albedo), len(Pass::Uv));
        let (position, id) = (len(Pass::Position), len(Pass::Id));
        let triangle = len(Pass::Triangle);
        refill(&mut self.rgba8, rgba8, [0; 4]);
        refill(&mut self.linear, linear, Vec4::ZERO);
        refill(&mut self.depth, depth, f32::INFINITY);
        refill(&mut self.normal, normal, Vec3::ZERO);
        refill(&mut self.albedo, albedo, Vec4::ZERO);
        refill(&mut self.uv, uv, Vec2::ZERO);
        refill(&mut self.position, position, Vec3::ZERO);
        refill(&mut self.id, id, 0);
        refill(&mut self.triangle, triangle, 0);
    }

    /// Splits the pictures into bands of `rows` rows each.
    pub(crate) fn bands(&mut self, rows: usize) -> Vec<Band<'_>> {
        let width = self.width as usize;
        let n_bands = (self.height as usize).div_ceil(rows);
        let mut rgba8 = split(&mut self.rgba8, width * rows);
        let mut linear = split(&mut self.linear, width * rows);
        let mut depth = split(&mut self.depth, width * rows);
        let mut normal = split(&mut self.normal, width * rows);
        let mut albedo = split(&mut self.albedo, width * rows);
        let mut uv = split(&mut self.uv, width * rows);
        let mut position = split(&mut self.position, width * rows);
        let mut id = split(&mut self.id, width * rows);
        let mut triangle = split(&mut self.triangle, width * rows);
        let band = |i: usize| Band {
            first_row: i * rows,
            rows: rows.min(self.height as usize - i * rows),
            width,
            rgba8: rgba8(),
            linear: linear(),
            depth: depth(),
            normal: normal(),
            albedo: albedo(),
            uv: uv(),
            position: position(),
            id: id(),
            triangle: triangle(),
        };
        (0..n_bands).map(band).collect()
    }
}

/// Some rows of a frame; absent passes are empty.
pub(crate) struct Band<'a> {
    pub first_row: usize,
    pub rows: usize,
    pub width: usize,
    pub rgba8: &'a mut [[u8; 4]],
    pub linear: &'a mut [Vec4],
    pub depth: &'a mut [f32],
    pub normal: &'a mut [Vec3],
    pub albedo: &'a mut [Vec4],
    pub uv: &'a mut [Vec2],
    pub position: &'a mut [Vec3],
    pub id: &'a mut [u32],
    pub triangle: &'a mut [u32],
}

fn refill<T: Copy>(buffer: &mut Vec<T>, len: usize, value: T) {
    buffer.clear();
    buffer.resize(len, value);
}

/// Hands out one chunk per call, and empty slices once there is nothing (left).
fn split<'a, T>(buffer: &'a mut [T], len: usize) -> impl FnMut() -> &'a mut [T] {
    let mut chunks = buffer.chunks_mut(len.max(1));
    move || chunks.next().unwrap_or_default()
}
