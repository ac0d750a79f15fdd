//! A file of tensors, as it is read.

use std::{collections::HashMap, path::Path};

use candle_core::{DType, Device, Tensor};
use safetensors::{Dtype, SafeTensors, tensor::TensorView};

use super::{
    column::{checksum, records_name},
    load_error::{LoadError, damaged, does_not_fit},
    state::{State, VERSION},
};
use crate::record::{EpisodeRecord, Records};

/// The only one, whose value is a checksum and the state.
pub(super) const METADATA_KEY: &str = "training";

pub(super) fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    std::fs::read(path)
        .map_err(|source| LoadError::Read { path: path.display().to_string(), source })
}

/// A file of tensors, none of them copied yet.
pub(super) struct File<'a> {
    path: &'a Path,
    pub(super) tensors: SafeTensors<'a>,
    pub(super) metadata: HashMap<String, String>,
}

impl<'a> File<'a> {
    pub(super) fn parse(path: &'a Path, bytes: &'a [u8]) -> Result<File<'a>, LoadError> {
        let damaged = |error: safetensors::SafeTensorError| damaged(path, error);
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
        let metadata = header.metadata().clone().unwrap_or_default();
        Ok(File { path, tensors: SafeTensors::deserialize(bytes).map_err(damaged)?, metadata })
    }

    pub(super) fn damaged(&self, reason: impl ToString) -> LoadError {
        damaged(self.path, reason)
    }

    /// The state of a training, if the file is as it was written.
    pub(super) fn state(&self) -> Result<State<'static>, LoadError> {
        let sealed = self.metadata.get(METADATA_KEY);
        let sealed = sealed.ok_or_else(|| self.damaged("it is no checkpoint"))?;
        // Before version 4 there was no checksum before the state.
        if sealed.starts_with('{') {
            let reason = format!("it is of a version before {VERSION}");
            return Err(does_not_fit(self.path, reason));
        }
        let (written, state) =
            sealed.split_once(' ').ok_or_else(|| self.damaged("it has no checksum"))?;
        let state_is: State<'static> =
            serde_json::from_str(state).map_err(|error| self.damaged(error))?;
        let mut views: Vec<_> = self.tensors.iter().collect();
        views.sort_by_key(|(name, _)| *name);
        let found = checksum(state, views.iter().map(|(name, view)| (*name, view)));
        // Where random bytes are tried they shall get past it, to what is behind.
        if u32::from_str_radix(written, 16) != Ok(found) && !cfg!(fuzzing) {
            let reason = format!("its checksum is {found:08x}, not {written} as it says itself");
            return Err(self.damaged(reason));
        }
        Ok(state_is)
    }

    /// The tensors of floats: everything but the memory.
    pub(super) fn tensors(&self) -> candle_core::Result<HashMap<String, Tensor>> {
        let floats = self.tensors.iter().filter(|(_, view)| view.dtype() == Dtype::F32);
        let tensor = |(name, view): (&str, TensorView)| {
            let (data, shape) = (view.data(), view.shape());
            let tensor = Tensor::from_raw_buffer(data, DType::F32, shape, &Device::Cpu)?;
            Ok((name.to_owned(), tensor))
        };
        floats.map(tensor).collect()
    }

    /// The records of the episodes.
    pub(super) fn records(&self) -> Result<Records, String> {
        let mut records = Records::default();
        let pieces = (0..).map(records_name).map_while(|name| self.tensors.tensor(&name).ok());
        for piece in pieces {
            let (numbers, []) = piece.data().as_chunks() else {
                return Err("a piece of the records is damaged".into());
            };
            if piece.dtype() != Dtype::F64 {
                return Err("a piece of the records holds something else than 64-bit floats".into());
            }
            let numbers: Vec<f64> =
                numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
            let (rows, []) = numbers.as_chunks() else {
                let columns = EpisodeRecord::COLUMNS;
                return Err(format!("a piece of the records is no table of {columns} columns"));
            };
            for row in rows {
                let record = EpisodeRecord::from_row(row);
                let number = records.len();
                records.push(record.ok_or_else(|| format!("no episode is as record {number}"))?);
            }
        }
        Ok(records)
    }

    /// A list of whole numbers.
    pub(super) fn column(&self, name: &str) -> Result<Vec<u32>, String> {
        let view = self.tensors.tensor(name).map_err(|_| format!("{name} is missing"))?;
        match view.data().as_chunks() {
            (numbers, []) if view.dtype() == Dtype::U32 && view.shape().len() == 1 => {
                Ok(numbers.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect())
            }
            _ => Err(format!("{name} is no list of 32-bit numbers")),
        }
    }
}
