//! The result: a set of pictures that agree with each other.

use cullet_raster::prefetch_all;
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

/// Makes a list so long; what is new is `value`. New memory of codes and ids, all zeros, comes from the system as threads
/// write to it, and not before.
fn set_len<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    if list.capacity() < len {
        *list = vec![value; len];
    } else {
        list.resize(len, value);
    }
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

    /// Takes a size, with pictures for `passes` that hold anything: all of them will be written everywhere.
    pub(crate) fn reset(&mut self, width: u32, height: u32, passes: Passes) {
        (self.width, self.height) = (width, height);
        let len = |pass| if passes.contains(pass) { self.len() } else { 0 };
        let (rgba8, linear, depth) = (len(Pass::Color), len(Pass::Linear), len(Pass::Depth));
        let (normal, albedo, uv) = (len(Pass::Normal), len(Pass::Albedo), len(Pass::Uv));
        let (position, id) = (len(Pass::Position), len(Pass::Id));
        let triangle = len(Pass::Triangle);
        set_len(&mut self.rgba8, rgba8, [0; 4]);
        set_len(&mut self.linear, linear, Vec4::ZERO);
        set_len(&mut self.depth, depth, f32::INFINITY);
        set_len(&mut self.normal, normal, Vec3::ZERO);
        set_len(&mut self.albedo, albedo, Vec4::ZERO);
        set_len(&mut self.uv, uv, Vec2::ZERO);
        set_len(&mut self.position, position, Vec3::ZERO);
        set_len(&mut self.id, id, 0);
        set_len(&mut self.triangle, triangle, 0);
    }

    /// Empties the pictures of `colors` and gives them their size; data stays as it is.
    pub(crate) fn make_room(&mut self, colors: Passes) {
        let len = |pass| if colors.contains(pass) { self.len() } else { 0 };
        let (rgba8, linear) = (len(Pass::Color), len(Pass::Linear));
        refill(&mut self.rgba8, rgba8, [0; 4]);
        refill(&mut self.linear, linear, Vec4::ZERO);
    }

    /// Splits the pictures into bands of `rows` rows each, the first of `first_rows`.
    pub(crate) fn bands(&mut self, first_rows: u32, rows: u32) -> Bands<'_> {
        let (width, height) = (self.width as usize, self.height as usize);
        let rest = Target {
            stride: width,
            rgba8: &mut self.rgba8,
            linear: &mut self.linear,
            depth: &mut self.depth,
            normal: &mut self.normal,
            albedo: &mut self.albedo,
            uv: &mut self.uv,
            position: &mut self.position,
            id: &mut self.id,
            triangle: &mut self.triangle,
        };
        Bands {
            rest: Some(rest),
            first_row: 0,
            height,
            next: first_rows as usize,
            rows: rows as usize,
        }
    }
}

/// The bands of a frame, one after the other.
pub(crate) struct Bands<'a> {
    rest: Option<Target<'a>>,
    first_row: usize,
    height: usize,
    /// Rows of the next band, and of all that follow.
    next: usize,
    rows: usize,
}

impl<'a> Iterator for Bands<'a> {
    type Item = Band<'a>;

    fn next(&mut self) -> Option<Band<'a>> {
        if self.first_row == self.height {
            return None;
        }
        let rest = self.rest.take()?;
        let rows = self.next.min(self.height - self.first_row);
        let n_pixels = rows * rest.stride;
        let (target, below) = rest.split_at(n_pixels);
        let band = Band { first_row: self.first_row, rows, target };
        (self.rest, self.first_row, self.next) = (Some(below), self.first_row + rows, self.rows);
        Some(band)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.height - self.first_row;
        let n = usize::from(left > 0) + left.saturating_sub(self.next).div_ceil(self.rows);
        (n, Some(n))
    }
}

impl ExactSizeIterator for Bands<'_> {}

/// Some rows of a frame.
pub(crate) struct Band<'a> {
    pub first_row: usize,
    pub rows: usize,
    pub target: Target<'a>,
}

/// Where the pictures of a rectangle go: each begins at its upper left pixel, and a row is `stride`
/// pixels after the one above. Absent passes are empty.
#[derive(Default)]
pub(crate) struct Target<'a> {
    pub stride: usize,
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

impl<'a> Target<'a> {
    /// What begins some columns to the right.
    pub(crate) fn right_of(&mut self, column: usize) -> Target<'_> {
        Target {
            stride: self.stride,
            rgba8: from(self.rgba8, column),
            linear: from(self.linear, column),
            depth: from(self.depth, column),
            normal: from(self.normal, column),
            albedo: from(self.albedo, column),
            uv: from(self.uv, column),
            position: from(self.position, column),
            id: from(self.id, column),
            triangle: from(self.triangle, column),
        }
    }

    /// Empties the data among `passes` of `size` pixels, to the right and down: nothing is there.
    pub(crate) fn clear_data(&mut self, size: [u32; 2], passes: Passes) {
        let part = (size, self.stride);
        for pass in Pass::ALL.into_iter().filter(|pass| passes.contains(*pass)) {
            match pass {
                Pass::Depth => clear(self.depth, part, f32::INFINITY),
                Pass::Normal => clear(self.normal, part, Vec3::ZERO),
                Pass::Albedo => clear(self.albedo, part, Vec4::ZERO),
                Pass::Uv => clear(self.uv, part, Vec2::ZERO),
                Pass::Position => clear(self.position, part, Vec3::ZERO),
                Pass::Id => clear(self.id, part, 0),
                Pass::Triangle => clear(self.triangle, part, 0),
                Pass::Color | Pass::Linear => {}
            }
        }
    }

    /// Up to pixel `at` and from there on.
    fn split_at(self, at: usize) -> (Target<'a>, Target<'a>) {
        let (rgba8, rgba8_rest) = split(self.rgba8, at);
        let (linear, linear_rest) = split(self.linear, at);
        let (depth, depth_rest) = split(self.depth, at);
        let (normal, normal_rest) = split(self.normal, at);
        let (albedo, albedo_rest) = split(self.albedo, at);
        let (uv, uv_rest) = split(self.uv, at);
        let (position, position_rest) = split(self.position, at);
        let (id, id_rest) = split(self.id, at);
        let (triangle, triangle_rest) = split(self.triangle, at);
        let stride = self.stride;
        let before =
            Target { stride, rgba8, linear, depth, normal, albedo, uv, position, id, triangle };
        let rest = Target {
            stride,
            rgba8: rgba8_rest,
            linear: linear_rest,
            depth: depth_rest,
            normal: normal_rest,
            albedo: albedo_rest,
            uv: uv_rest,
            position: position_rest,
            id: id_rest,
            triangle: triangle_rest,
        };
        (before, rest)
    }
}

/// Rows are sent for so many before they are written.
pub(crate) const ROWS_AHEAD: usize = 8;

fn refill<T: Copy>(buffer: &mut Vec<T>, len: usize, value: T) {
    buffer.clear();
    buffer.resize(len, value);
}

fn clear<T: Copy>(picture: &mut [T], ([width, height], stride): ([u32; 2], usize), nothing: T) {
    for row in 0..height as usize {
        let later = (row + ROWS_AHEAD) * stride;
        prefetch_all(picture, later..later + width as usize);
        picture[row * stride..][..width as usize].fill(nothing);
    }
}

fn from<T>(buffer: &mut [T], start: usize) -> &mut [T] {
    buffer.get_mut(start..).unwrap_or_default()
}

/// Two empty parts of a picture that is not there.
fn split<T>(buffer: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
    let at = at.min(buffer.len());
    buffer.split_at_mut(at)
}
