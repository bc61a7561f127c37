//! The kinds of picture a frame can hold.

/// One kind of picture. All passes of a frame come from one visibility, so they agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Pass {
    /// Shaded colour, 8-bit sRGB.
    Color,
    /// Shaded colour, linear f32, before any encoding.
    Linear,
    /// Distance along the view axis in scene units, infinite where nothing is.
    Depth,
    /// Unit normal in world space, turned to the viewer on back faces; 0 where nothing is.
    Normal,
    /// Base colour with its alpha, linear, without light.
    Albedo,
    /// First texture coordinates, as in the file; 0 where nothing is.
    Uv,
    /// World-space position; 0 where nothing is.
    Position,
    /// Object number in scene order.
    Id,
    /// Triangle number: over all objects in scene order, and within an object as in its mesh.
    Triangle,
}

impl Pass {
    /// Every pass.
    pub const ALL: [Pass; 9] = [
        Pass::Color,
        Pass::Linear,
        Pass::Depth,
        Pass::Normal,
        Pass::Albedo,
        Pass::Uv,
        Pass::Position,
        Pass::Id,
        Pass::Triangle,
    ];
}

/// A set of passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Passes(u16);

impl Passes {
    /// Nothing at all: visibility is found and thrown away.
    pub const NONE: Passes = Passes(0);
    /// The 8-bit colour picture alone.
    pub const COLOR: Passes = Passes(1 << Pass::Color as u8);

    /// This set and `pass`.
    #[must_use]
    pub const fn with(self, pass: Pass) -> Passes {
        Passes(self.0 | 1 << pass as u8)
    }

    /// This set less `others`.
    pub(crate) const fn without(self, others: Passes) -> Passes {
        Passes(self.0 & !others.0)
    }

    /// The colours among them.
    pub(crate) const fn colors(self) -> Passes {
        Passes(self.0 & Passes::COLORS)
    }

    /// All but colours: what is never blended.
    pub(crate) const fn data(self) -> Passes {
        Passes(self.0 & !Passes::COLORS)
    }

    const COLORS: u16 = 1 << Pass::Color as u8 | 1 << Pass::Linear as u8;

    /// Whether `pass` is wanted.
    pub const fn contains(self, pass: Pass) -> bool {
        self.0 & (1 << pass as u8) != 0
    }

    /// Whether a kernel has to run.
    pub const fn needs_color(self) -> bool {
        self.contains(Pass::Color) || self.contains(Pass::Linear)
    }
}

impl FromIterator<Pass> for Passes {
    fn from_iter<I: IntoIterator<Item = Pass>>(passes: I) -> Self {
        passes.into_iter().fold(Passes::NONE, Passes::with)
    }
}
