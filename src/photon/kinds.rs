//! Two kinds of photons share the light that reaches a surface over a mirror or a glass out between them: caustics, whose
//! first event is a mirror or a glass, L S⁺ D …, and light that is scattered first, L D … S⁺ D.
//!
//! They set out to different places, are found in different numbers and are kept apart in the picture's layers: each has
//! its own plan, map and estimate.

/// Something for each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinds<T> {
    pub caustic: T,
    pub bounced: T,
}

impl<T> Kinds<T> {
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> Kinds<U> {
        Kinds { caustic: f(self.caustic), bounced: f(self.bounced) }
    }
    pub fn as_ref(&self) -> Kinds<&T> {
        Kinds { caustic: &self.caustic, bounced: &self.bounced }
    }
    pub fn as_mut(&mut self) -> Kinds<&mut T> {
        Kinds { caustic: &mut self.caustic, bounced: &mut self.bounced }
    }
    pub fn into_array(self) -> [T; 2] {
        [self.caustic, self.bounced]
    }
}
