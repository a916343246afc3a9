//! The objects that a point is inside of.

use crate::scene::ObjectId;

/// Objects inside of each other at most; of more the one that was entered first is forgotten.
const DEEPEST: usize = 6;

/// Objects in the order in which they were entered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inside {
    objects: [u32; DEEPEST],
    count: u8,
}

impl Inside {
    /// Out in the open.
    pub const NOTHING: Inside = Inside { objects: [0; DEEPEST], count: 0 };

    pub fn objects(&self) -> impl DoubleEndedIterator<Item = ObjectId> + '_ {
        self.objects[..usize::from(self.count)].iter().map(|&object| ObjectId(object))
    }

    pub fn is_nothing(&self) -> bool {
        self.count == 0
    }

    /// Whether one more object would be one too many.
    pub fn is_full(&self) -> bool {
        usize::from(self.count) == DEEPEST
    }

    /// Nothing changes inside of an object that is entered again.
    pub fn entered(self, object: ObjectId) -> Inside {
        let mut next = self.left(object);
        if usize::from(next.count) == DEEPEST {
            next.objects.rotate_left(1);
            next.count -= 1;
        }
        next.objects[usize::from(next.count)] = object.0;
        next.count += 1;
        next
    }

    pub fn left(mut self, object: ObjectId) -> Inside {
        let count = usize::from(self.count);
        if let Some(i) = self.objects[..count].iter().position(|&o| o == object.0) {
            self.objects.copy_within(i + 1..count, i);
            self.count -= 1;
            // Equal sets are equal bit by bit.
            self.objects[count - 1] = 0;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_entered_is_left_in_any_order() {
        let all = (0..4).map(ObjectId).fold(Inside::NOTHING, Inside::entered);
        assert_eq!(all.objects().map(|o| o.0).collect::<Vec<_>>(), [0, 1, 2, 3]);
        let some = all.left(ObjectId(1)).left(ObjectId(9)).entered(ObjectId(2));
        assert_eq!(some.objects().map(|o| o.0).collect::<Vec<_>>(), [0, 3, 2]);
        assert_eq!(some.left(ObjectId(3)).left(ObjectId(0)).left(ObjectId(2)), Inside::NOTHING);
    }

    #[test]
    fn the_outermost_of_too_many_is_forgotten() {
        let deep = (0..9).map(ObjectId).fold(Inside::NOTHING, Inside::entered);
        assert_eq!(deep.objects().map(|o| o.0).collect::<Vec<_>>(), [3, 4, 5, 6, 7, 8]);
    }
}
