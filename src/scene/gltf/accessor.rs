//! Numbers of a buffer: vectors of any component type, with sparse changes. Every offset is checked before the first number is
//! read, and nothing is copied, so what a file claims takes no memory.

use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, buffer};

use super::buffers::Buffers;

/// Values of an accessor, by their number.
pub(super) struct Values<'a> {
    pub(super) count: usize,
    /// Components of a value, 1 to 4.
    pub(super) width: usize,
    pub(super) component: ComponentType,
    is_normalized: bool,
    base: Option<Block<'a>>,
    sparse: Option<Sparse<'a>>,
}

struct Sparse<'a> {
    /// Ascending.
    places: Vec<u32>,
    values: Block<'a>,
}

/// Elements of one size, some bytes apart.
#[derive(Clone, Copy)]
struct Block<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Values<'a> {
    /// What an accessor stands for.
    ///
    /// # Errors
    /// What is wrong with it, without its place.
    pub(super) fn of(
        root: &Root,
        buffers: &'a Buffers,
        index: Index<Accessor>,
    ) -> Result<Values<'a>, String> {
        let accessor = &root.accessors[index.value()];
        let in_accessor = |what: String| format!("accessor {}: {what}; export it again", index.value());
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            return Err(in_accessor("has no type that glTF knows".to_owned()));
        };
        let width = match kind {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 => 4,
            Type::Mat2 | Type::Mat3 | Type::Mat4 => return Err(in_accessor("holds matrices".to_owned())),
        };
        let component = component.0;
        let size = width * component.size();
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let base =
            accessor.buffer_view.map(|view| Block::of(root, buffers, view, offset, accessor.count.0, size));
        let base = base.transpose().map_err(in_accessor)?;
        let count = usize::try_from(accessor.count.0).map_err(|_| in_accessor("is too long".to_owned()))?;
        let sparse = match &accessor.sparse {
            None => None,
            Some(sparse) => {
                let (indices, values) = (&sparse.indices, &sparse.values);
                let Checked::Valid(kind) = indices.component_type else {
                    return Err(in_accessor("has sparse indices of no type that glTF knows".to_owned()));
                };
                let kind = kind.0;
                let block = |view, offset, size| Block::of(root, buffers, view, offset, sparse.count.0, size);
                let places =
                    block(indices.buffer_view, indices.byte_offset.0, kind.size()).map_err(in_accessor)?;
                let values = block(values.buffer_view, values.byte_offset.0, size).map_err(in_accessor)?;
                let places: Vec<u32> = (0..sparse.count.0 as usize).map(|i| places.whole(i, kind)).collect();
                let is_ascending = places.windows(2).all(|pair| pair[0] < pair[1]);
                if !is_ascending || places.last().is_some_and(|&last| last as usize >= count) {
                    return Err(in_accessor("has sparse indices out of order or out of range".to_owned()));
                }
                Some(Sparse { places, values })
            }
        };
        Ok(Values { count, width, component, is_normalized: accessor.normalized, base, sparse })
    }

    /// Whether there is a number in the file for every value.
    pub(super) fn is_stored(&self) -> bool {
        self.base.is_some()
    }

    /// A value, as floats; components that it does not have are 0. Whole numbers are mapped to [−1, 1] if they are normalised.
    pub(super) fn vector(&self, index: usize) -> [f64; 4] {
        let mut vector = [0.0; 4];
        let Some((block, index)) = self.found(index) else { return vector };
        let size = self.component.size();
        let bytes = &block.bytes[index * block.stride..];
        for (axis, value) in vector.iter_mut().enumerate().take(self.width) {
            *value = number(&bytes[axis * size..], self.component);
            if self.is_normalized {
                *value = normalized(*value, self.component);
            }
        }
        vector
    }

    /// As [`Values::vector`], of whole numbers that are normalised whatever the file says of them.
    pub(super) fn share(&self, index: usize) -> [f64; 4] {
        match self.is_normalized {
            true => self.vector(index),
            false => self.vector(index).map(|value| normalized(value, self.component)),
        }
    }

    /// A whole number.
    pub(super) fn whole(&self, index: usize) -> u32 {
        self.found(index).map_or(0, |(block, index)| block.whole(index, self.component))
    }

    fn found(&self, index: usize) -> Option<(Block<'a>, usize)> {
        let changed = self.sparse.as_ref().and_then(|sparse| {
            let place = sparse.places.binary_search(&(index as u32)).ok()?;
            Some((sparse.values, place))
        });
        changed.or(self.base.map(|base| (base, index)))
    }
}

impl<'a> Block<'a> {
    /// `count` elements of `size` bytes from `offset` in a view.
    fn of(
        root: &Root,
        buffers: &'a Buffers,
        view: Index<buffer::View>,
        offset: u64,
        count: u64,
        size: usize,
    ) -> Result<Block<'a>, String> {
        let number = view.value();
        let bytes = buffers.view(root, number)?;
        let view = &root.buffer_views[number];
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(format!("bufferView {number} has elements of {size} bytes, {stride} bytes apart"));
        }
        let needed = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride as u64).and_then(|bytes| bytes.checked_add(size as u64)),
        };
        let end =
            needed.and_then(|needed| needed.checked_add(offset)).filter(|&end| end <= bytes.len() as u64);
        if end.is_none() {
            let there = bytes.len();
            return Err(format!(
                "{count} elements of {size} bytes do not fit into bufferView {number} of {there} bytes"
            ));
        }
        Ok(Block { bytes: &bytes[(offset as usize).min(bytes.len())..], stride })
    }

    fn whole(&self, index: usize, kind: ComponentType) -> u32 {
        // Exact: whole numbers of 32 bits fit double precision.
        number(&self.bytes[index * self.stride..], kind) as u32
    }
}

/// One component, little-endian.
fn number(bytes: &[u8], kind: ComponentType) -> f64 {
    let [a, b] = [bytes[0], *bytes.get(1).unwrap_or(&0)];
    let four = || [a, b, bytes[2], bytes[3]];
    match kind {
        ComponentType::I8 => f64::from(a as i8),
        ComponentType::U8 => f64::from(a),
        ComponentType::I16 => f64::from(i16::from_le_bytes([a, b])),
        ComponentType::U16 => f64::from(u16::from_le_bytes([a, b])),
        ComponentType::U32 => f64::from(u32::from_le_bytes(four())),
        ComponentType::F32 => f64::from(f32::from_le_bytes(four())),
    }
}

/// What a whole number stands for as a share of the largest one.
fn normalized(value: f64, kind: ComponentType) -> f64 {
    let largest = match kind {
        ComponentType::I8 => f64::from(i8::MAX),
        ComponentType::U8 => f64::from(u8::MAX),
        ComponentType::I16 => f64::from(i16::MAX),
        ComponentType::U16 => f64::from(u16::MAX),
        ComponentType::U32 => f64::from(u32::MAX),
        ComponentType::F32 => return value,
    };
    (value / largest).max(-1.0)
}
