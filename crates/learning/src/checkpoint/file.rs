//! A safetensors file that is being read.

use std::{collections::HashMap, path::Path};

use candle_core::{DType, Device, Tensor};
use safetensors::{Dtype, SafeTensors, tensor::TensorView};

use super::{
    column::{checksum, records_name},
    load_error::{LoadError, damaged, mismatch},
    state::{State, VERSION},
};
use crate::record::{EpisodeRecord, Records};

/// The only metadata key of a checkpoint. Its value is the checksum, a space, and the state as
/// JSON.
pub(super) const METADATA_KEY: &str = "training";

/// Reads a file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    std::fs::read(path)
        .map_err(|source| LoadError::Read { path: path.display().to_string(), source })
}

/// A parsed safetensors file, whose tensors borrow the bytes of the file.
pub(super) struct File<'a> {
    path: &'a Path,
    pub(super) tensors: SafeTensors<'a>,
    pub(super) metadata: HashMap<String, String>,
}

impl<'a> File<'a> {
    /// Parses the header of the file.
    pub(super) fn parse(path: &'a Path, bytes: &'a [u8]) -> Result<File<'a>, LoadError> {
        let damaged = |error: safetensors::SafeTensorError| damaged(path, error);
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
        let metadata = header.metadata().clone().unwrap_or_default();
        Ok(File { path, tensors: SafeTensors::deserialize(bytes).map_err(damaged)?, metadata })
    }

    /// Returns the error for a damaged file.
    pub(super) fn damaged(&self, reason: impl ToString) -> LoadError {
        damaged(self.path, reason)
    }

    /// Validates the checksum and returns the state of the training run.
    pub(super) fn state(&self) -> Result<State<'static>, LoadError> {
        let metadata = self.metadata.get(METADATA_KEY);
        let metadata = metadata.ok_or_else(|| self.damaged("it is not a checkpoint"))?;
        // Versions before 4 have no checksum before the state.
        if metadata.starts_with('{') {
            let reason = format!("its version is below 4 (expected: {VERSION})");
            return Err(mismatch(self.path, reason));
        }
        let (written, state) =
            metadata.split_once(' ').ok_or_else(|| self.damaged("it has no checksum"))?;
        let parsed: State<'static> =
            serde_json::from_str(state).map_err(|error| self.damaged(error))?;
        let mut views: Vec<_> = self.tensors.iter().collect();
        views.sort_by_key(|(name, _)| *name);
        let computed = checksum(state, views.iter().map(|(name, view)| (*name, view)));
        // When fuzzing, a wrong checksum is accepted; otherwise, the fuzzer would never reach the
        // code that reads the contents.
        if u32::from_str_radix(written, 16) != Ok(computed) && !cfg!(fuzzing) {
            let reason = format!("its checksum is {computed:08x} (expected: {written})");
            return Err(self.damaged(reason));
        }
        Ok(parsed)
    }

    /// Returns the tensors of 32-bit floats: the networks and Adam's moments.
    pub(super) fn tensors(&self) -> candle_core::Result<HashMap<String, Tensor>> {
        let floats = self.tensors.iter().filter(|(_, view)| view.dtype() == Dtype::F32);
        let tensor = |(name, view): (&str, TensorView)| {
            let (data, shape) = (view.data(), view.shape());
            let tensor = Tensor::from_raw_buffer(data, DType::F32, shape, &Device::Cpu)?;
            Ok((name.to_owned(), tensor))
        };
        floats.map(tensor).collect()
    }

    /// Returns the episode records.
    pub(super) fn records(&self) -> Result<Records, String> {
        let mut records = Records::default();
        let chunks = (0..).map(records_name).map_while(|name| self.tensors.tensor(&name).ok());
        for chunk in chunks {
            if chunk.dtype() != Dtype::F64 {
                return Err("a record tensor has the wrong type (expected: F64)".into());
            }
            let (numbers, []) = chunk.data().as_chunks() else {
                return Err("the size of a record tensor is not a multiple of 8 bytes".into());
            };
            let numbers: Vec<f64> =
                numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
            let (rows, []) = numbers.as_chunks() else {
                let columns = EpisodeRecord::COLUMNS;
                return Err(format!("a record tensor does not have {columns} columns"));
            };
            for row in rows {
                let record = EpisodeRecord::from_row(row);
                let number = records.len();
                records.push(record.ok_or_else(|| format!("record {number} is invalid"))?);
            }
        }
        Ok(records)
    }

    /// Returns the values of a one-dimensional tensor of 32-bit integers.
    pub(super) fn column(&self, name: &str) -> Result<Vec<u32>, String> {
        let view = self.tensors.tensor(name).map_err(|_| format!("missing tensor '{name}'"))?;
        match view.data().as_chunks() {
            (numbers, []) if view.dtype() == Dtype::U32 && view.shape().len() == 1 => {
                Ok(numbers.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
            }
            _ => Err(format!("tensor '{name}' is not a list of 32-bit integers")),
        }
    }
}
