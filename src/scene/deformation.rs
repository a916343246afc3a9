//! Meshes that change their shape: vertices at equal intervals of time, in between on straight lines · object space,
//! metres, seconds.
//!
//! Before the first frame and after the last one the mesh keeps its shape. Normals are interpolated as the frames have them,
//! without being made unit again: what turns is N = n/|n|, with n linear in time.

use super::camera::Shutter;
use crate::math::{Bounds3, Point3, Vec3};

/// Frames that the shutter may see, counting those of the rest before and after: what Embree's motion blur can hold.
pub const MAX_STEPS: usize = 129;

/// All vertices at one time.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct VertexFrame {
    pub positions: Vec<[f32; 3]>,
    /// As many as positions, or none.
    pub normals: Vec<[f32; 3]>,
}

/// A mesh's shapes in the course of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Of the first frame, s.
    pub start: f64,
    /// From one frame to the next, s.
    pub interval: f64,
    /// Two at least.
    pub frames: Vec<VertexFrame>,
}

/// Two frames, the second's part, and what that changes by in a second.
#[derive(Clone, Copy, Debug)]
pub struct Between<'a> {
    pub from: &'a VertexFrame,
    pub to: &'a VertexFrame,
    pub part: f64,
    pub rate: f64,
}

impl Between<'_> {
    /// Of `pick` of both frames.
    fn at(&self, pick: impl Fn(&VertexFrame) -> [f32; 3]) -> Vec3 {
        let [a, b] = [self.from, self.to].map(|frame| Point3::from_f32(pick(frame)).to_vec());
        a + (b - a) * self.part
    }
    fn change(&self, pick: impl Fn(&VertexFrame) -> [f32; 3]) -> Vec3 {
        let [a, b] = [self.from, self.to].map(|frame| Point3::from_f32(pick(frame)).to_vec());
        (b - a) * self.rate
    }
    pub fn positions(&self, corners: [u32; 3]) -> [Point3; 3] {
        corners.map(|i| Point3::from_vec(self.at(|frame| frame.positions[i as usize])))
    }
    /// m/s.
    pub fn velocities(&self, corners: [u32; 3]) -> [Vec3; 3] {
        corners.map(|i| self.change(|frame| frame.positions[i as usize]))
    }
    pub fn normals(&self, corners: [u32; 3]) -> [Vec3; 3] {
        corners.map(|i| self.at(|frame| frame.normals[i as usize]))
    }
    /// Per second.
    pub fn turning(&self, corners: [u32; 3]) -> [Vec3; 3] {
        corners.map(|i| self.change(|frame| frame.normals[i as usize]))
    }
}

impl Deformation {
    /// s.
    pub fn end(&self) -> f64 {
        self.start + self.interval * (self.frames.len() - 1) as f64
    }

    /// The frames about `time`.
    pub fn between(&self, time: f64) -> Between<'_> {
        let place = (time - self.start) / self.interval;
        let last = self.frames.len() - 1;
        let earlier = (place.max(0.0) as usize).min(last - 1);
        let within = (0.0..=last as f64).contains(&place);
        let (from, to) = (&self.frames[earlier], &self.frames[earlier + 1]);
        let rate = if within { self.interval.recip() } else { 0.0 };
        Between { from, to, part: (place - earlier as f64).clamp(0.0, 1.0), rate }
    }

    /// All vertices at `time`, as storage rounds them.
    pub fn at(&self, time: f64) -> VertexFrame {
        let between = self.between(time);
        let blended = |pick: fn(&VertexFrame) -> &Vec<[f32; 3]>| {
            let vertices = (0..pick(between.from).len()).map(|i| between.at(|frame| pick(frame)[i]));
            vertices.map(|v| v.to_array().map(|x| x as f32)).collect()
        };
        VertexFrame { positions: blended(|frame| &frame.positions), normals: blended(|frame| &frame.normals) }
    }

    /// What the shutter sees of it, as frames at the same interval that cover the time that it is open; `None`: nothing
    /// changes.
    pub fn seen(&self, shutter: Shutter) -> Option<Deformation> {
        let steps = self.steps(shutter)?;
        let last = self.frames.len() as i64 - 1;
        let frames: Vec<VertexFrame> =
            steps.clone().map(|step| self.frames[step.clamp(0, last) as usize].clone()).collect();
        let changes = frames.iter().any(|frame| *frame != frames[0]);
        changes.then(|| Deformation {
            start: self.start + self.interval * *steps.start() as f64,
            interval: self.interval,
            frames,
        })
    }

    /// How many frames cover the time that the shutter is open.
    pub fn step_count(&self, shutter: Shutter) -> f64 {
        let [first, last] = self.span(shutter);
        last - first + 1.0
    }

    fn steps(&self, shutter: Shutter) -> Option<std::ops::RangeInclusive<i64>> {
        let [first, last] = self.span(shutter);
        let countable = !shutter.is_instant() && self.step_count(shutter) <= MAX_STEPS as f64;
        countable.then_some(first as i64..=last as i64)
    }

    fn span(&self, shutter: Shutter) -> [f64; 2] {
        let place = |time: f64| (time - self.start) / self.interval;
        let first = place(shutter.open).floor();
        [first, place(shutter.close).ceil().max(first + 1.0)]
    }

    /// Around all frames: what goes on straight lines stays within.
    pub fn bounds(&self) -> Bounds3 {
        Bounds3::from_points(self.frames.iter().flat_map(|frame| &frame.positions).map(|&p| Point3::from_f32(p)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One vertex at x = 0, 1, 3 at the times 1, 1.5, 2.
    fn going() -> Deformation {
        let frame = |x: f32| VertexFrame { positions: vec![[x, 0.0, 0.0]], normals: vec![] };
        Deformation { start: 1.0, interval: 0.5, frames: [0.0, 1.0, 3.0].map(frame).to_vec() }
    }

    #[test]
    fn vertices_go_straight_and_rest_before_and_after() {
        let going = going();
        for (time, x, v) in
            [(0.0, 0.0, 0.0), (1.0, 0.0, 2.0), (1.25, 0.5, 2.0), (1.75, 2.0, 4.0), (2.0, 3.0, 4.0), (9.0, 3.0, 0.0)]
        {
            let between = going.between(time);
            assert_eq!(between.positions([0; 3])[0].x, x, "at {time}");
            assert_eq!(between.velocities([0; 3])[0].x, v, "at {time}");
            assert_eq!(going.at(time).positions[0][0], x as f32);
        }
    }

    #[test]
    fn the_shutter_sees_the_frames_that_cover_it() {
        let shutter = |open, close| Shutter { open, close };
        let seen = |open, close| going().seen(shutter(open, close)).map(|seen| (seen.start, seen.frames.len()));
        assert_eq!(seen(1.1, 1.4), Some((1.0, 2)));
        assert_eq!(seen(0.2, 1.6), Some((0.0, 5)));
        assert_eq!(seen(2.0, 3.0), None);
        assert_eq!(seen(1.2, 1.2), None);
        assert!(going().step_count(shutter(0.0, 100.0)) > MAX_STEPS as f64);
        for time in [0.2, 0.9, 1.3, 1.6] {
            let seen = going().seen(shutter(0.2, 1.6)).expect("it moves");
            assert_eq!(seen.at(time), going().at(time));
        }
    }
}
