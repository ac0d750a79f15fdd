//! Parameters of a node.
//!
//! A program declares each parameter once, with its type, default, description and constraints.
//! `-p` and `--params-file` override the default at startup, and `ros2 param set` changes the value
//! while the node runs.

mod client;
mod file;
mod services;
pub(crate) mod value;

use std::{
    collections::BTreeMap,
    fmt::Debug,
    ops::RangeInclusive,
    path::Path,
    sync::{Arc, OnceLock},
};

use parking_lot::{Mutex, MutexGuard};
use serde::Serialize;
use thiserror::Error;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

pub use client::ParameterClient;
pub use file::ParameterFileError;
pub(crate) use services::ParameterServices;
pub use value::{FromParameter, Override, OverrideError, ParameterType, ParameterValue};

use crate::{arguments::Arguments, escape::escaped, names::Naming};

/// A check of a value that has the declared type. Its error is the reason for rejecting the value,
/// on one line.
pub type Check = fn(&ParameterValue) -> Result<(), String>;

/// Returns the values that other parameters get when a parameter is set to a value.
pub type Implications = fn(&ParameterValue) -> Vec<(&'static str, ParameterValue)>;

/// The description and constraints of a parameter.
///
/// # Examples
///
/// ```
/// use ros_runtime::parameters::{Descriptor, ParameterValue};
///
/// let mode = Descriptor::read_only("the camera's mode").choices(["color", "gray"]);
/// assert_eq!(mode.additional_constraints(), "one of: color, gray");
/// let rate = Descriptor::dynamic("images per second").range(1.0..=60.0);
/// let crop = Descriptor::dynamic("[x, y], in pixels").check(|value| match value {
///     ParameterValue::IntegerArray(numbers) if numbers.len() == 2 => Ok(()),
///     _ => Err("expected two integers".to_owned()),
/// });
/// ```
#[derive(Clone, Debug, Default)]
pub struct Descriptor {
    /// The description, which `ros2 param describe` shows.
    pub description: String,
    /// Whether the value cannot change after the declaration.
    pub read_only: bool,
    /// The valid values of a string; empty if any value is valid.
    pub choices: Vec<String>,
    /// The smallest and largest valid numbers; for an array, they apply to each element.
    pub range: Option<(f64, f64)>,
    /// A check for constraints that choices and a range cannot express.
    pub check: Option<Check>,
    /// The values of other parameters that setting this one implies.
    pub implications: Option<Implications>,
}

impl Descriptor {
    /// Describes a parameter whose value cannot change after the declaration.
    pub fn read_only(description: &str) -> Descriptor {
        Descriptor { description: description.to_owned(), read_only: true, ..Default::default() }
    }

    /// Describes a parameter whose value can change while the node runs.
    pub fn dynamic(description: &str) -> Descriptor {
        Descriptor { description: description.to_owned(), ..Default::default() }
    }

    /// Sets the valid range of a number, including both ends.
    pub fn range(self, range: RangeInclusive<f64>) -> Descriptor {
        Descriptor { range: Some((*range.start(), *range.end())), ..self }
    }

    /// Sets the valid values of a string.
    pub fn choices<S: ToString>(self, choices: impl IntoIterator<Item = S>) -> Descriptor {
        Descriptor {
            choices: choices.into_iter().map(|choice| choice.to_string()).collect(),
            ..self
        }
    }

    /// Sets an additional check.
    pub fn check(self, check: Check) -> Descriptor {
        Descriptor { check: Some(check), ..self }
    }

    /// Makes the parameter a preset for others: setting it while the node runs also sets these. A
    /// value that the same request sets explicitly takes precedence. The others must be declared and
    /// are set without their own implications.
    ///
    /// At startup, values are not implied, so that overrides keep their effect: declare the preset
    /// first, and the others with the defaults that it implies.
    ///
    /// # Examples
    ///
    /// ```
    /// use ros_runtime::parameters::{Descriptor, ParameterValue};
    ///
    /// let quality = Descriptor::dynamic("image quality").choices(["low", "high"]).implies(|value| {
    ///     let high = *value == ParameterValue::String("high".to_owned());
    ///     vec![("rate", ParameterValue::Double(if high { 60.0 } else { 15.0 }))]
    /// });
    /// assert!(quality.implications.is_some());
    /// ```
    pub fn implies(self, implications: Implications) -> Descriptor {
        Descriptor { implications: Some(implications), ..self }
    }

    /// Returns the constraints for which `rcl_interfaces/ParameterDescriptor` has no separate
    /// field: the choices, or an empty string.
    pub fn additional_constraints(&self) -> String {
        match self.choices.is_empty() {
            true => String::new(),
            false => format!("one of: {}", self.choices.join(", ")),
        }
    }
}

/// The error returned for an invalid value or an unknown parameter.
#[derive(Debug, Error, PartialEq)]
pub enum ParameterError {
    /// The type of the value differs from the declared one.
    #[error("parameter '{}' is {value}: expected {expected}", escaped(.name))]
    WrongType {
        /// The parameter.
        name: String,
        /// The invalid value.
        value: ParameterValue,
        /// The declared type.
        expected: ParameterType,
    },
    /// A number is outside the declared range.
    #[error("parameter '{}' is {value}: expected {low} to {high}", escaped(.name))]
    OutOfRange {
        /// The parameter.
        name: String,
        /// The invalid value.
        value: ParameterValue,
        /// The smallest valid value.
        low: f64,
        /// The largest valid value.
        high: f64,
    },
    /// A string is not one of the declared choices.
    #[error("parameter '{}' is {value}: expected one of {}", escaped(.name), choices.join(", "))]
    UnknownChoice {
        /// The parameter.
        name: String,
        /// The invalid value.
        value: ParameterValue,
        /// The valid values.
        choices: Vec<String>,
    },
    /// The declared check rejects the value.
    #[error("parameter '{}' is {value}: {reason}", escaped(.name))]
    Refused {
        /// The parameter.
        name: String,
        /// The invalid value.
        value: ParameterValue,
        /// The reason that the check returned.
        reason: String,
    },
    /// A number is infinite or NaN.
    #[error("parameter '{}' is not a finite number", escaped(.0))]
    NotFinite(String),
    /// The parameter is read-only.
    #[error("parameter '{}' is read-only: set it when the node starts", escaped(.0))]
    ReadOnly(String),
    /// The parameter is not declared.
    #[error("unknown parameter '{}' (expected: {})", escaped(.name), declared.join(", "))]
    Undeclared {
        /// The parameter.
        name: String,
        /// The declared parameters.
        declared: Vec<String>,
    },
}

#[derive(Clone, Debug)]
struct Declared {
    value: ParameterValue,
    default: ParameterValue,
    descriptor: Descriptor,
}

/// A declared parameter with its value, for programs that list parameters or offer them as options.
///
/// # Examples
///
/// ```
/// use ros_runtime::{Arguments, Node};
///
/// let parameters = Node::parameters_only("camera", &Arguments::default())?;
/// let declarations = parameters.declarations();
/// let clock = declarations.iter().find(|declaration| declaration.name == "use_sim_time");
/// assert_eq!(clock.map(|clock| clock.expected.as_str()), Some("true or false"));
/// # Ok::<(), ros_runtime::node::NodeError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Declaration {
    /// The name.
    pub name: String,
    /// The description.
    pub description: String,
    /// The type in words, such as `a list of numbers`.
    pub expected: String,
    /// The current value.
    pub value: ParameterValue,
    /// The default value, which an override replaces.
    pub default: ParameterValue,
    /// Whether the value cannot change after the declaration.
    pub read_only: bool,
    /// The valid values of a string; empty if any value is valid.
    pub choices: Vec<String>,
    /// The smallest and largest valid numbers; for an array, they apply to each element.
    pub range: Option<(f64, f64)>,
}

/// The parameters of a node. Clones share them.
///
/// # Examples
///
/// ```
/// use ros_runtime::{
///     Arguments,
///     names::Naming,
///     parameters::{Descriptor, ParameterValue, Parameters},
/// };
///
/// let line = ["camera", "--ros-args", "-p", "rate:=20"];
/// let arguments = Arguments::parse(line.map(str::to_owned))?;
/// // In a node: `node.parameters()`.
/// let parameters = Parameters::new(&Naming::new("camera", &arguments.remaps)?, &arguments)?;
///
/// let descriptor = Descriptor::dynamic("image rate, in Hz").range(1.0..=60.0);
/// assert_eq!(parameters.declare("rate", 30.0, descriptor)?, 20.0);
/// let error = parameters.set("rate", ParameterValue::Double(90.0)).unwrap_err();
/// assert_eq!(error.to_string(), "parameter 'rate' is the number 90: expected 1 to 60");
/// assert_eq!(parameters.get::<f64>("rate"), Some(20.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Parameters {
    overrides: Arc<Overrides>,
    declared: Arc<Mutex<BTreeMap<String, Declared>>>,
    /// The sender for the receiver that [`Parameters::listen`] has returned.
    listener: Arc<OnceLock<UnboundedSender<Change>>>,
}

/// The name of a parameter and its new value.
pub(crate) type Change = (String, ParameterValue);

#[derive(Debug, Default)]
struct Overrides {
    /// Overrides from `-p` and from file sections for this node; an undeclared name is an error.
    own: BTreeMap<String, ParameterValue>,
    /// Overrides from wildcard sections of files; their parameters may belong to other nodes.
    shared: BTreeMap<String, ParameterValue>,
}

impl Parameters {
    /// Returns the parameters of a node with the overrides from its arguments. No parameter is
    /// declared yet.
    ///
    /// # Errors
    ///
    /// Returns an error if a parameter file cannot be read or is invalid.
    pub fn new(naming: &Naming, arguments: &Arguments) -> Result<Parameters, ParameterFileError> {
        let mut overrides = Overrides::default();
        for path in &arguments.parameter_files {
            for section in file::read(path)? {
                if section.matches(&naming.fully_qualified()) {
                    let target = if section.is_for_all() {
                        &mut overrides.shared
                    } else {
                        &mut overrides.own
                    };
                    target.extend(section.parameters);
                }
            }
        }
        for rule in &arguments.overrides {
            if rule.node.as_deref().is_none_or(|node| node == naming.node) {
                overrides.own.insert(rule.name.clone(), rule.value.clone());
            }
        }
        let overrides = Arc::new(overrides);
        Ok(Parameters { overrides, declared: Arc::default(), listener: Arc::default() })
    }

    /// Declares a parameter and returns its value, which is the override if there is one and
    /// `default` otherwise.
    ///
    /// # Errors
    ///
    /// Returns an error if the value violates the declared type or constraints.
    pub fn declare<T: FromParameter>(
        &self,
        name: &str,
        default: T,
        descriptor: Descriptor,
    ) -> Result<T, ParameterError> {
        let given = self.overrides.own.get(name).or_else(|| self.overrides.shared.get(name));
        let default = default.into_value();
        // The default is also checked, because it may come from a file.
        let value = given.unwrap_or(&default).clone();
        let value = accept(name, value, T::TYPE, &descriptor)?;
        let entry = Declared { value: value.clone(), default, descriptor };
        let mut declared = self.lock();
        declared.insert(name.to_owned(), entry);
        self.notify((name.to_owned(), value.clone()));
        drop(declared);
        T::from_value(&value).ok_or(ParameterError::WrongType {
            name: name.to_owned(),
            value,
            expected: T::TYPE,
        })
    }

    /// Rejects overrides of undeclared parameters. Call this method after the last declaration.
    ///
    /// Overrides from the wildcard sections of parameter files are exempt: they may belong to other
    /// nodes.
    ///
    /// # Errors
    ///
    /// Returns an error if an override names an undeclared parameter, for example a misspelt one.
    pub fn reject_undeclared(&self) -> Result<(), ParameterError> {
        let declared = self.lock();
        match self.overrides.own.keys().find(|name| !declared.contains_key(*name)) {
            None => Ok(()),
            Some(name) => Err(ParameterError::Undeclared {
                name: name.clone(),
                declared: declared.keys().cloned().collect(),
            }),
        }
    }

    /// Returns the current value of a parameter, or `None` if it is undeclared or has another type.
    pub fn get<T: FromParameter>(&self, name: &str) -> Option<T> {
        T::from_value(&self.lock().get(name)?.value)
    }

    /// Sets a parameter of a running node.
    ///
    /// # Errors
    ///
    /// Returns an error if the parameter is undeclared or read-only, or if the value is invalid.
    pub fn set(&self, name: &str, value: ParameterValue) -> Result<(), ParameterError> {
        self.set_all([(name, value)])
    }

    /// Sets several parameters of a running node, or none of them.
    ///
    /// # Errors
    ///
    /// Same as [`Parameters::set`]. After an error, all parameters keep their values.
    pub fn set_all<'a>(
        &self,
        changes: impl IntoIterator<Item = (&'a str, ParameterValue)>,
    ) -> Result<(), ParameterError> {
        let mut declared = self.lock();
        let mut implied = Vec::new();
        let mut accepted = Vec::new();
        for (name, value) in changes {
            let entry = changeable(&declared, name)?;
            let value = accept(name, value, entry.value.kind(), &entry.descriptor)?;
            for (other, value) in entry.descriptor.implications.map_or(Vec::new(), |of| of(&value))
            {
                let entry = changeable(&declared, other)?;
                let value = accept(other, value, entry.value.kind(), &entry.descriptor)?;
                implied.push((other.to_owned(), value));
            }
            accepted.push((name.to_owned(), value));
        }
        implied.retain(|(name, _)| accepted.iter().all(|(explicit, _)| explicit != name));
        accepted.extend(implied);
        for (name, value) in accepted {
            if let Some(entry) = declared.get_mut(&name)
                && entry.value != value
            {
                entry.value = value.clone();
                self.notify((name, value));
            }
        }
        Ok(())
    }

    /// Returns whether setting a parameter also sets others.
    pub(crate) fn has_implications(&self, name: &str) -> bool {
        let declared = self.lock();
        declared.get(name).is_some_and(|entry| entry.descriptor.implications.is_some())
    }

    /// Returns a receiver that yields all declared values and then every change. Only the first
    /// call returns an open receiver; later calls return closed ones.
    pub(crate) fn listen(&self) -> UnboundedReceiver<Change> {
        let (sender, receiver) = unbounded_channel();
        let declared = self.lock();
        if self.listener.set(sender).is_ok() {
            for (name, entry) in declared.iter() {
                self.notify((name.clone(), entry.value.clone()));
            }
        }
        receiver
    }

    fn notify(&self, change: Change) {
        if let Some(listener) = self.listener.get() {
            // Sending fails if the node, and with it the receiver, has been dropped.
            let _ = listener.send(change);
        }
    }

    /// Returns the current values of all declared parameters, by name.
    pub fn values(&self) -> BTreeMap<String, ParameterValue> {
        self.lock().iter().map(|(name, entry)| (name.clone(), entry.value.clone())).collect()
    }

    /// Returns the declarations of all parameters, sorted by name.
    pub fn declarations(&self) -> Vec<Declaration> {
        let declaration = |(name, entry): (&String, &Declared)| {
            let Declared { value, default, descriptor } = entry.clone();
            let Descriptor { description, read_only, choices, range, .. } = descriptor;
            let (name, expected) = (name.clone(), value.kind().to_string());
            Declaration { name, description, expected, value, default, read_only, choices, range }
        };
        self.lock().iter().map(declaration).collect()
    }

    fn entry(&self, name: &str) -> Option<Declared> {
        self.lock().get(name).cloned()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Declared>> {
        self.declared.lock()
    }
}

/// Reads the parameters of one node, such as `/robot1/camera`, from a parameter file. A section for
/// this node takes precedence over wildcard sections.
///
/// # Errors
///
/// Returns an error if the file cannot be read or is not a parameter file.
///
/// # Examples
///
/// ```no_run
/// use std::path::Path;
///
/// use ros_runtime::parameters::read_file_of;
///
/// let values = read_file_of(Path::new("config.yaml"), "/camera")?;
/// println!("rate: {:?}", values.get("rate"));
/// # Ok::<(), ros_runtime::parameters::ParameterFileError>(())
/// ```
pub fn read_file_of(
    path: &Path,
    fully_qualified_name: &str,
) -> Result<BTreeMap<String, ParameterValue>, ParameterFileError> {
    let sections = file::read(path)?.into_iter();
    Ok(sections.filter(|s| s.matches(fully_qualified_name)).flat_map(|s| s.parameters).collect())
}

/// Returns a parameter that can be changed.
fn changeable<'a>(
    declared: &'a BTreeMap<String, Declared>,
    name: &str,
) -> Result<&'a Declared, ParameterError> {
    let Some(entry) = declared.get(name) else {
        let declared = declared.keys().cloned().collect();
        return Err(ParameterError::Undeclared { name: name.to_owned(), declared });
    };
    match entry.descriptor.read_only {
        true => Err(ParameterError::ReadOnly(name.to_owned())),
        false => Ok(entry),
    }
}

/// Returns the value, converted to the declared type, if the declaration allows it.
fn accept(
    name: &str,
    value: ParameterValue,
    expected: ParameterType,
    descriptor: &Descriptor,
) -> Result<ParameterValue, ParameterError> {
    let name = name.to_owned();
    let value = match value.converted(expected) {
        Ok(value) => value,
        Err(value) => {
            return Err(ParameterError::WrongType { name, value, expected });
        }
    };
    let numbers = value.numbers();
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(ParameterError::NotFinite(name));
    }
    if let Some((low, high)) = descriptor.range
        && numbers.iter().any(|number| *number < low || *number > high)
    {
        return Err(ParameterError::OutOfRange { name, value, low, high });
    }
    if let ParameterValue::String(text) = &value
        && !(descriptor.choices.is_empty() || descriptor.choices.contains(text))
    {
        let choices = descriptor.choices.clone();
        return Err(ParameterError::UnknownChoice { name, value, choices });
    }
    if let Some(check) = descriptor.check
        && let Err(reason) = check(&value)
    {
        return Err(ParameterError::Refused { name, value, reason });
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters(line: &str) -> Parameters {
        let line = format!("node --ros-args {line}");
        let arguments = Arguments::parse(line.split_whitespace().map(str::to_owned)).unwrap();
        let naming = Naming::new("planner", &arguments.remaps).unwrap();
        Parameters::new(&naming, &arguments).unwrap()
    }

    #[test]
    fn the_last_override_of_the_node_wins() {
        let parameters = parameters("-p episodes:=5 -p episodes:=6 -p other_node:episodes:=7");
        assert_eq!(parameters.declare("episodes", 1000, Descriptor::default()), Ok(6));
        assert_eq!(parameters.declare("seed", 3, Descriptor::default()), Ok(3));
        assert_eq!(parameters.reject_undeclared(), Ok(()));
    }

    #[test]
    fn errors_name_the_value_and_what_is_valid() {
        let parameters =
            parameters("-p episodes:=abc -p seed:=-1 -p preset:=nonsense -p misspelt:=1");
        let message = |result: Result<(), ParameterError>| result.unwrap_err().to_string();
        assert_eq!(
            message(parameters.declare("episodes", 1000, Descriptor::default()).map(drop)),
            "parameter 'episodes' is the string 'abc': expected an integer"
        );
        let positive = Descriptor::default().range(0.0..=10.0);
        assert_eq!(
            message(parameters.declare("seed", 0, positive).map(drop)),
            "parameter 'seed' is the integer -1: expected 0 to 10"
        );
        let choices = Descriptor::default().choices(["paper"]);
        assert_eq!(
            message(parameters.declare("preset", "paper".to_owned(), choices).map(drop)),
            "parameter 'preset' is the string 'nonsense': expected one of paper"
        );
        let infinite = accept(
            "rate",
            ParameterValue::Double(f64::INFINITY),
            ParameterType::Double,
            &Descriptor::default(),
        );
        assert_eq!(message(infinite.map(drop)), "parameter 'rate' is not a finite number");
        assert!(message(parameters.reject_undeclared()).contains("unknown parameter 'episodes'"));
    }

    #[test]
    fn errors_escape_the_names_and_values_that_they_quote() {
        let parameters = parameters("");
        let choices = Descriptor::dynamic("").choices(["paper"]);
        parameters.declare("preset", "paper".to_owned(), choices).unwrap();
        let set = |name, text: &str| {
            let result = parameters.set(name, ParameterValue::String(text.to_owned()));
            result.unwrap_err().to_string()
        };
        assert_eq!(
            set("preset", "0\ne"),
            r"parameter 'preset' is the string '0\ne': expected one of paper"
        );
        assert_eq!(set("pre\nset", "paper"), r"unknown parameter 'pre\nset' (expected: preset)");
        assert_eq!(
            ParameterError::ReadOnly("a\nb".to_owned()).to_string(),
            r"parameter 'a\nb' is read-only: set it when the node starts"
        );
        assert_eq!(
            ParameterError::NotFinite("a\nb".to_owned()).to_string(),
            r"parameter 'a\nb' is not a finite number"
        );
    }

    #[test]
    fn an_integer_is_converted_to_a_double_but_not_vice_versa() {
        let parameters = parameters("-p rate:=20 -p depth:=1.5");
        assert_eq!(parameters.declare("rate", 0.0, Descriptor::default()), Ok(20.0));
        assert!(parameters.declare("depth", 1, Descriptor::default()).is_err());
    }

    #[test]
    fn a_number_is_converted_to_a_list_of_one_number() {
        let parameters = parameters("-p range:=20 -p other:=0.5");
        assert_eq!(parameters.declare("range", vec![], Descriptor::default()), Ok(vec![20.0]));
        assert_eq!(parameters.declare("other", vec![], Descriptor::default()), Ok(vec![0.5]));
    }

    #[test]
    fn only_dynamic_parameters_can_be_set() {
        let parameters = parameters("");
        parameters.declare("seed", 0, Descriptor::read_only("")).unwrap();
        parameters.declare("rate", 0.5, Descriptor::dynamic("").range(0.0..=1.0)).unwrap();
        let read_only = ParameterError::ReadOnly("seed".to_owned());
        assert_eq!(parameters.set("seed", ParameterValue::Integer(1)), Err(read_only));
        assert_eq!(parameters.set("rate", ParameterValue::Double(0.75)), Ok(()));
        assert!(parameters.set("rate", ParameterValue::Double(1.5)).is_err());
        assert_eq!(parameters.get("rate"), Some(0.75));
    }

    #[test]
    fn sets_all_parameters_or_none_and_notifies_only_of_changes() {
        let parameters = parameters("");
        for name in ["rate", "share"] {
            parameters.declare(name, 0.5, Descriptor::dynamic("").range(0.0..=1.0)).unwrap();
        }
        let mut listener = parameters.listen();
        let double = ParameterValue::Double;
        let both = |share| [("rate", double(0.75)), ("share", double(share))];
        assert!(parameters.set_all(both(1.5)).is_err());
        assert_eq!(parameters.get("rate"), Some(0.5));
        assert_eq!(parameters.set_all(both(0.5)), Ok(()));
        let mut received = Vec::new();
        while let Ok(change) = listener.try_recv() {
            received.push(change);
        }
        let expected = [("rate", 0.5), ("share", 0.5), ("rate", 0.75)];
        assert_eq!(received, expected.map(|(name, value)| (name.to_owned(), double(value))));
    }

    #[test]
    fn a_preset_sets_other_parameters_unless_the_request_sets_them() {
        let parameters = parameters("");
        let double = ParameterValue::Double;
        let descriptor = || Descriptor::dynamic("").range(0.0..=1.0);
        parameters.declare("rate", 0.0, descriptor()).unwrap();
        parameters.declare("share", 0.0, descriptor()).unwrap();
        let preset = descriptor().implies(|level| {
            let ParameterValue::Double(level) = *level else { unreachable!("the type is checked") };
            let value = ParameterValue::Double(2.0 * level);
            vec![("rate", value.clone()), ("share", value)]
        });
        parameters.declare("level", 0.0, preset).unwrap();
        let values = || ["rate", "share"].map(|name| parameters.get::<f64>(name).unwrap());
        parameters.set("level", double(0.25)).unwrap();
        assert_eq!(values(), [0.5, 0.5]);
        parameters.set_all([("share", double(0.75)), ("level", double(0.125))]).unwrap();
        assert_eq!(values(), [0.25, 0.75]);
        // Nothing changes if an implied value is invalid.
        let error = parameters.set("level", double(0.75)).unwrap_err().to_string();
        assert_eq!(error, "parameter 'rate' is the number 1.5: expected 0 to 1");
        assert_eq!((values(), parameters.get("level")), ([0.25, 0.75], Some(0.125)));
    }

    #[test]
    fn a_check_rejects_a_value_with_its_reason() {
        let pair = |value: &ParameterValue| match value {
            ParameterValue::DoubleArray(numbers) if numbers.len() != 2 => {
                Err(format!("expected 2 numbers, not {}", numbers.len()))
            }
            _ => Ok(()),
        };
        let descriptor = || Descriptor::dynamic("").check(pair);
        let result = parameters("-p place:=[1.0]").declare("place", vec![0.0, 0.0], descriptor());
        let message = "parameter 'place' is the list [1.0]: expected 2 numbers, not 1";
        assert_eq!(result.unwrap_err().to_string(), message);

        let parameters = parameters("");
        parameters.declare("place", vec![0.0, 0.0], descriptor()).unwrap();
        let place = |numbers: &[f64]| ParameterValue::DoubleArray(numbers.to_vec());
        assert_eq!(parameters.set("place", place(&[1.0])).unwrap_err().to_string(), message);
        assert_eq!(parameters.get("place"), Some(vec![0.0, 0.0]));
        assert_eq!(parameters.set("place", place(&[1.0, 2.0])), Ok(()));
        assert_eq!(parameters.get("place"), Some(vec![1.0, 2.0]));
    }
}
