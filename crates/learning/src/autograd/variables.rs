//! The parameters of a network, keyed by the names that candle-nn's layers request.

use std::collections::BTreeMap;

use candle_core::{DType, Device, Result, Shape, Tensor, Var};
use candle_nn::{Init, VarBuilder, var_builder::SimpleBackend};
use parking_lot::Mutex;

/// A function that creates a parameter from its name and shape.
pub(super) type Make<'a> = dyn FnMut(&str, &[usize]) -> Result<Tensor> + Send + 'a;

/// Parameters, keyed by name.
#[derive(Debug)]
pub(super) struct Variables(BTreeMap<String, Var>);

impl Variables {
    /// Builds layers with `build`, and creates each parameter with `make` when a layer requests it.
    pub(super) fn make<T>(
        make: &mut Make<'_>,
        build: impl FnOnce(VarBuilder<'_>) -> Result<T>,
    ) -> Result<(Variables, T)> {
        let source = Mutex::new(Source { make, made: BTreeMap::new() });
        let requests = Box::new(Requests(&source));
        let built = build(VarBuilder::from_backend(requests, DType::F32, Device::Cpu))?;
        Ok((Variables(source.into_inner().made), built))
    }

    /// Returns the parameter with the given name.
    pub(super) fn get(&self, name: &str) -> Result<&Var> {
        self.0.get(name).ok_or_else(|| candle_core::Error::Msg(format!("missing tensor '{name}'")))
    }

    /// Iterates over the parameters, sorted by name.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, &Var)> {
        self.0.iter().map(|(name, variable)| (name.as_str(), variable))
    }
}

/// The function that creates parameters, and the parameters created so far.
struct Source<'a, 'b> {
    make: &'a mut Make<'b>,
    made: BTreeMap<String, Var>,
}

/// Implements the interface through which candle-nn requests parameters.
struct Requests<'a, 'b, 'c>(&'a Mutex<Source<'b, 'c>>);

impl SimpleBackend for Requests<'_, '_, '_> {
    /// Ignores candle-nn's initial values, which are not reproducible.
    fn get(&self, shape: Shape, name: &str, _: Init, _: DType, _: &Device) -> Result<Tensor> {
        let mut source = self.0.lock();
        let variable = Var::from_tensor(&(source.make)(name, shape.dims())?)?;
        let tensor = variable.as_tensor().clone();
        source.made.insert(name.to_owned(), variable);
        Ok(tensor)
    }

    fn get_unchecked(&self, name: &str, _: DType, _: &Device) -> Result<Tensor> {
        Err(candle_core::Error::Msg(format!("parameter '{name}': requested without a shape")))
    }

    fn contains_tensor(&self, _: &str) -> bool {
        true
    }
}
