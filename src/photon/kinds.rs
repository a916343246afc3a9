//! Kinds of photons share the light that reaches a surface otherwise than straight from a light out between them: over a
//! mirror or a glass caustics, L S⁺ D; what goes on from there, L S⁺ D … S⁺ D; and light that is scattered first,
//! L D … S⁺ D. Where photons also bring what comes straight from a surface that scatters, L … D D, there are two more
//! kinds: sent out as caustics, and scattered first.
//!
//! They set out to different places, come in different numbers, are narrow or wide, and belong to different layers of the
//! picture: each kind has its own map and estimate.

impl<T> Kinds<Vec<T>> {
    /// Adds those of another list to each list.
    pub fn append(&mut self, mut other: Kinds<Vec<T>>) {
        self.caustic.append(&mut other.caustic);
        self.onward.append(&mut other.onward);
        self.bounced.append(&mut other.bounced);
        self.onward_scattered.append(&mut other.onward_scattered);
        self.scattered.append(&mut other.scattered);
    }
}

/// Something for each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinds<T> {
    pub caustic: T,
    /// Sent out as caustics, and scattered since.
    pub onward: T,
    pub bounced: T,
    /// Sent out as caustics, and now straight from a surface that scatters.
    pub onward_scattered: T,
    /// Scattered first, and straight from a surface that scatters.
    pub scattered: T,
}

impl<T> Kinds<T> {
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> Kinds<U> {
        Kinds {
            caustic: f(self.caustic),
            onward: f(self.onward),
            bounced: f(self.bounced),
            onward_scattered: f(self.onward_scattered),
            scattered: f(self.scattered),
        }
    }
    pub fn as_ref(&self) -> Kinds<&T> {
        let Kinds { caustic, onward, bounced, onward_scattered, scattered } = self;
        Kinds { caustic, onward, bounced, onward_scattered, scattered }
    }
    pub fn into_array(self) -> [T; 5] {
        [self.caustic, self.onward, self.bounced, self.onward_scattered, self.scattered]
    }
}
