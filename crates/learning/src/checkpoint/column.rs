//! A tensor in a checkpoint that is being written.

use std::{borrow::Cow, ops::Range};

use candle_core::Tensor;
use crc::{CRC_32_ISCSI, Crc, Table};
use safetensors::{Dtype, View};
use task::Image;

use crate::{record::EpisodeRecord, replay_memory::ReplayMemory};

/// Maximum number of images per tensor in the file.
pub(super) const CHUNK: u64 = 256;

/// Returns the name of an image tensor.
pub(super) fn images_name(chunk: usize) -> String {
    format!("memory.images.{chunk:06}")
}

/// Returns the name of a record tensor.
pub(super) fn records_name(chunk: usize) -> String {
    format!("records.{chunk:06}")
}

/// A tensor in the file. Images and records are converted only when their bytes are needed.
pub(super) enum Column<'a> {
    /// A candle tensor.
    Tensor(Tensor),
    /// Images as bytes, `[count, 7, 20, 3]`.
    Images { memory: &'a ReplayMemory, numbers: Range<u64>, shape: [usize; 4] },
    /// Records as 64-bit floats, `[count, columns]`.
    Records { records: &'a [EpisodeRecord], shape: [usize; 2] },
}

impl<'a> Column<'a> {
    pub(super) fn images(memory: &'a ReplayMemory, numbers: Range<u64>) -> Column<'a> {
        let count = (numbers.end - numbers.start) as usize;
        Column::Images { memory, numbers, shape: [count, Image::HEIGHT, Image::WIDTH, 3] }
    }

    pub(super) fn records(records: &'a [EpisodeRecord]) -> Column<'a> {
        Column::Records { records, shape: [records.len(), EpisodeRecord::COLUMNS] }
    }
}

impl View for Column<'_> {
    fn dtype(&self) -> Dtype {
        match self {
            Column::Tensor(tensor) => View::dtype(tensor),
            Column::Images { .. } => Dtype::U8,
            Column::Records { .. } => Dtype::F64,
        }
    }

    fn shape(&self) -> &[usize] {
        match self {
            Column::Tensor(tensor) => View::shape(tensor),
            Column::Images { shape, .. } => shape,
            Column::Records { shape, .. } => shape,
        }
    }

    fn data(&self) -> Cow<'_, [u8]> {
        match self {
            Column::Tensor(tensor) => View::data(tensor),
            Column::Images { memory, numbers, .. } => {
                let images = numbers.clone().map(|number| memory.frame(number).image);
                images.collect::<Vec<_>>().into_flattened().into()
            }
            Column::Records { records, .. } => {
                let numbers = records.iter().flat_map(EpisodeRecord::to_row);
                numbers.flat_map(f64::to_le_bytes).collect()
            }
        }
    }

    fn data_len(&self) -> usize {
        match self {
            Column::Tensor(tensor) => View::data_len(tensor),
            Column::Images { shape, .. } => shape.iter().product(),
            Column::Records { shape, .. } => shape.iter().product::<usize>() * size_of::<f64>(),
        }
    }
}

/// Returns the CRC-32C checksum of a state and its tensors. The tensors must be sorted by name.
pub(super) fn checksum<'a, V: View + 'a>(
    state: &str,
    tensors: impl Iterator<Item = (&'a str, &'a V)>,
) -> u32 {
    static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISCSI);
    let mut digest = CRC.digest();
    digest.update(state.as_bytes());
    for (name, tensor) in tensors {
        digest.update(format!("{name} {:?} {:?}", tensor.dtype(), tensor.shape()).as_bytes());
        digest.update(&tensor.data());
    }
    digest.finalize()
}
