//! That an accessor stays within its buffers, before anything is read through it or allocated for it.

use gltf::accessor::{DataType, Dimensions};
use gltf::{Accessor, buffer};

use super::buffers::Buffers;

/// Kinds of elements that a reader understands.
pub(super) type Kinds = &'static [(Dimensions, DataType)];

pub(super) const VECTORS: Kinds = &[(Dimensions::Vec3, DataType::F32)];
pub(super) const TEXTURE_COORDINATES: Kinds =
    &[(Dimensions::Vec2, DataType::F32), (Dimensions::Vec2, DataType::U8), (Dimensions::Vec2, DataType::U16)];
pub(super) const COLOURS: Kinds = &[
    (Dimensions::Vec3, DataType::F32),
    (Dimensions::Vec3, DataType::U8),
    (Dimensions::Vec3, DataType::U16),
    (Dimensions::Vec4, DataType::F32),
    (Dimensions::Vec4, DataType::U8),
    (Dimensions::Vec4, DataType::U16),
];
pub(super) const INDICES: Kinds =
    &[(Dimensions::Scalar, DataType::U8), (Dimensions::Scalar, DataType::U16), (Dimensions::Scalar, DataType::U32)];

/// What is wrong with it, if anything.
pub(super) fn check(accessor: &Accessor<'_>, buffers: &Buffers<'_>, kinds: Kinds) -> Result<(), String> {
    let kind = (accessor.dimensions(), accessor.data_type());
    let index = accessor.index();
    if !kinds.contains(&kind) {
        return Err(format!("accessors[{index}] holds {:?} of {:?}, which has no meaning here", kind.0, kind.1));
    }
    if accessor.count() == 0 {
        return Err(format!("accessors[{index}] is empty"));
    }
    let outside = |part: &str| format!("accessors[{index}] reaches out of its {part}");
    if let Some(view) = accessor.view() {
        let fits = fits(&view, buffers, accessor.offset(), accessor.size(), accessor.count());
        return if fits { check_sparse(accessor, buffers) } else { Err(outside("buffer view")) };
    }
    if accessor.sparse().is_none() {
        return Err(format!("accessors[{index}] has no buffer view"));
    }
    // What is not in the file is zero, and may be no more than what is.
    if accessor.count() > buffers.total_bytes() {
        return Err(format!("accessors[{index}] claims {} elements, more than the file has bytes", accessor.count()));
    }
    check_sparse(accessor, buffers)
}

fn check_sparse(accessor: &Accessor<'_>, buffers: &Buffers<'_>) -> Result<(), String> {
    let Some(sparse) = accessor.sparse() else { return Ok(()) };
    let (indices, values) = (sparse.indices(), sparse.values());
    let width = match indices.index_type() {
        gltf::accessor::sparse::IndexType::U8 => 1,
        gltf::accessor::sparse::IndexType::U16 => 2,
        gltf::accessor::sparse::IndexType::U32 => 4,
    };
    let index = accessor.index();
    let fit = sparse.count() > 0
        && fits(&indices.view(), buffers, indices.offset(), width, sparse.count())
        && fits(&values.view(), buffers, values.offset(), accessor.size(), sparse.count());
    let bytes = buffers.view(&indices.view()).and_then(|bytes| bytes.get(indices.offset()..));
    let (true, Some(bytes)) = (fit, bytes) else {
        return Err(format!("accessors[{index}].sparse reaches out of its buffer views"));
    };
    let stride = indices.view().stride().unwrap_or(width);
    let number = |i: usize| bytes[i * stride..][..width].iter().rev().fold(0, |n, b| n << 8 | usize::from(*b));
    let numbers: Vec<usize> = (0..sparse.count()).map(number).collect();
    if !numbers.is_sorted_by(|a, b| a < b) || numbers.last().is_some_and(|last| *last >= accessor.count()) {
        return Err(format!("accessors[{index}].sparse has indices that do not increase or are out of range"));
    }
    Ok(())
}

/// Whether `count` elements of `size` bytes from `offset` on lie in the view, and the view in its buffer.
fn fits(view: &buffer::View<'_>, buffers: &Buffers<'_>, offset: usize, size: usize, count: usize) -> bool {
    let stride = view.stride().unwrap_or(size);
    let end = stride.checked_mul(count - 1).and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(offset));
    let there = buffers.view(view).map(<[u8]>::len);
    stride >= size && end.is_some_and(|end| there.is_some_and(|there| end <= there))
}
