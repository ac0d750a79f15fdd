//! Parameters: declared once with a type, a default, a description and what values they may take;
//! overridden by `-p` and `--params-file` at the start, and by `ros2 param set` while running.

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

use crate::{arguments::Arguments, names::Naming};

/// A parameter's own check: `Ok`, or what is wrong with a value, which is of the declared type.
pub type Check = fn(&ParameterValue) -> Result<(), String>;

/// What a parameter is for and which values it takes.
#[derive(Clone, Debug, Default)]
pub struct Descriptor {
    /// Shown by `ros2 param describe`.
    pub description: String,
    /// Whether the value is fixed once the node has started.
    pub read_only: bool,
    /// The values of a string parameter, if they can be listed.
    pub choices: Vec<String>,
    /// The smallest and the largest value of a number.
    pub range: Option<(f64, f64)>,
    /// What neither choices nor a range can say.
    pub check: Option<Check>,
}

impl Descriptor {
    /// A parameter that is read once, at the start.
    pub fn read_only(description: &str) -> Descriptor {
        Descriptor { description: description.to_owned(), read_only: true, ..Default::default() }
    }

    /// A parameter that may change while the node runs.
    pub fn dynamic(description: &str) -> Descriptor {
        Descriptor { description: description.to_owned(), ..Default::default() }
    }

    /// The numbers that are allowed, the ends included.
    pub fn range(self, range: RangeInclusive<f64>) -> Descriptor {
        Descriptor { range: Some((*range.start(), *range.end())), ..self }
    }

    /// The strings that are allowed.
    pub fn choices<S: ToString>(self, choices: impl IntoIterator<Item = S>) -> Descriptor {
        Descriptor {
            choices: choices.into_iter().map(|choice| choice.to_string()).collect(),
            ..self
        }
    }

    /// What else is asked of a value.
    pub fn check(self, check: Check) -> Descriptor {
        Descriptor { check: Some(check), ..self }
    }

    /// The constraints that have no field of their own in rcl_interfaces/ParameterDescriptor.
    pub fn additional_constraints(&self) -> String {
        match self.choices.is_empty() {
            true => String::new(),
            false => format!("one of: {}", self.choices.join(", ")),
        }
    }
}

/// Why a parameter cannot have a value.
#[derive(Debug, Error, PartialEq)]
pub enum ParameterError {
    /// Another type than the declared one.
    #[error("parameter '{name}' is {value}: expected {expected}")]
    WrongType {
        /// The parameter.
        name: String,
        /// What was given.
        value: ParameterValue,
        /// What was declared.
        expected: ParameterType,
    },
    /// A number outside the declared range.
    #[error("parameter '{name}' is {value}: expected {low} to {high}")]
    OutOfRange {
        /// The parameter.
        name: String,
        /// What was given.
        value: ParameterValue,
        /// The smallest value allowed.
        low: f64,
        /// The largest value allowed.
        high: f64,
    },
    /// A string that is none of the declared ones.
    #[error("parameter '{name}' is {value}: expected one of {}", choices.join(", "))]
    NoSuchChoice {
        /// The parameter.
        name: String,
        /// What was given.
        value: ParameterValue,
        /// What would be right.
        choices: Vec<String>,
    },
    /// A value that its parameter's own check refuses.
    #[error("parameter '{name}' is {value}: {reason}")]
    Refused {
        /// The parameter.
        name: String,
        /// What was given.
        value: ParameterValue,
        /// What is wrong with it.
        reason: String,
    },
    /// A number that is none.
    #[error("parameter '{0}' is not a finite number")]
    NotFinite(String),
    /// A change of what is fixed.
    #[error("parameter '{0}' is read-only: give it when the node starts")]
    ReadOnly(String),
    /// A parameter that the node does not have.
    #[error("no parameter '{name}': this node has {}", declared.join(", "))]
    Undeclared {
        /// The parameter.
        name: String,
        /// The parameters that there are.
        declared: Vec<String>,
    },
}

#[derive(Clone, Debug)]
struct Declared {
    value: ParameterValue,
    default: ParameterValue,
    descriptor: Descriptor,
}

/// A declared parameter, for programs that offer it as an option.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Declaration {
    /// Its name.
    pub name: String,
    /// What it is for.
    pub description: String,
    /// What kind of value it takes, in words.
    pub expected: String,
    /// Its value now.
    pub value: ParameterValue,
    /// The value that it has without an override.
    pub default: ParameterValue,
    /// Whether the value is fixed once the node has started.
    pub read_only: bool,
    /// The values of a string parameter, if they can be listed.
    pub choices: Vec<String>,
    /// The smallest and the largest value of a number.
    pub range: Option<(f64, f64)>,
}

/// A node's parameters; a cheap handle that can be shared.
#[derive(Clone, Debug)]
pub struct Parameters {
    overrides: Arc<Overrides>,
    declared: Arc<Mutex<BTreeMap<String, Declared>>>,
    /// Who is told of changes.
    listener: Arc<OnceLock<UnboundedSender<Change>>>,
}

/// A parameter, and its value from now on.
pub(crate) type Change = (String, ParameterValue);

#[derive(Debug, Default)]
struct Overrides {
    /// What was meant for this node by name or by `-p`: a misspelt one is an error.
    own: BTreeMap<String, ParameterValue>,
    /// What stood under a wildcard in a file: others may be meant.
    shared: BTreeMap<String, ParameterValue>,
}

impl Parameters {
    /// The overrides of a command line for one node; its files are read here.
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

    /// Declares a parameter; its value is the override, or else the default.
    pub fn declare<T: FromParameter>(
        &self,
        name: &str,
        default: T,
        descriptor: Descriptor,
    ) -> Result<T, ParameterError> {
        let given = self.overrides.own.get(name).or_else(|| self.overrides.shared.get(name));
        let default = default.into_value();
        // A default may come from a file, too.
        let value = given.unwrap_or(&default).clone();
        let value = accept(name, value, T::TYPE, &descriptor)?;
        let entry = Declared { value: value.clone(), default, descriptor };
        let mut declared = self.lock();
        declared.insert(name.to_owned(), entry);
        self.tell((name.to_owned(), value.clone()));
        drop(declared);
        T::from_value(&value).ok_or(ParameterError::WrongType {
            name: name.to_owned(),
            value,
            expected: T::TYPE,
        })
    }

    /// Fails if an override was meant for this node and names no parameter of it.
    pub fn refuse_undeclared(&self) -> Result<(), ParameterError> {
        let declared = self.lock();
        match self.overrides.own.keys().find(|name| !declared.contains_key(*name)) {
            None => Ok(()),
            Some(name) => Err(ParameterError::Undeclared {
                name: name.clone(),
                declared: declared.keys().cloned().collect(),
            }),
        }
    }

    /// The present value of a declared parameter.
    pub fn get<T: FromParameter>(&self, name: &str) -> Option<T> {
        T::from_value(&self.lock().get(name)?.value)
    }

    /// Changes a parameter of a running node.
    pub fn set(&self, name: &str, value: ParameterValue) -> Result<(), ParameterError> {
        self.set_all([(name, value)])
    }

    /// Changes several parameters of a running node, or none of them.
    pub fn set_all<'a>(
        &self,
        changes: impl IntoIterator<Item = (&'a str, ParameterValue)>,
    ) -> Result<(), ParameterError> {
        let mut declared = self.lock();
        let mut accepted = Vec::new();
        for (name, value) in changes {
            let Some(entry) = declared.get(name) else {
                let declared = declared.keys().cloned().collect();
                return Err(ParameterError::Undeclared { name: name.to_owned(), declared });
            };
            if entry.descriptor.read_only {
                return Err(ParameterError::ReadOnly(name.to_owned()));
            }
            let value = accept(name, value, entry.value.kind(), &entry.descriptor)?;
            accepted.push((name.to_owned(), value));
        }
        for (name, value) in accepted {
            if let Some(entry) = declared.get_mut(&name)
                && entry.value != value
            {
                entry.value = value.clone();
                self.tell((name, value));
            }
        }
        Ok(())
    }

    /// What is declared now, and every change from now on. There is one listener.
    pub(crate) fn listen(&self) -> UnboundedReceiver<Change> {
        let (sender, receiver) = unbounded_channel();
        let declared = self.lock();
        // A second listener would hear nothing.
        if self.listener.set(sender).is_ok() {
            for (name, entry) in declared.iter() {
                self.tell((name.clone(), entry.value.clone()));
            }
        }
        receiver
    }

    fn tell(&self, change: Change) {
        if let Some(listener) = self.listener.get() {
            // Nobody listens any more once the node ends.
            let _ = listener.send(change);
        }
    }

    /// Every parameter with its present value, by name.
    pub fn values(&self) -> BTreeMap<String, ParameterValue> {
        self.lock().iter().map(|(name, entry)| (name.clone(), entry.value.clone())).collect()
    }

    /// All that is declared, by name.
    pub fn declarations(&self) -> Vec<Declaration> {
        let declaration = |(name, entry): (&String, &Declared)| {
            let Declared { value, default, descriptor } = entry.clone();
            let Descriptor { description, read_only, choices, range, check: _ } = descriptor;
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

/// What a file says about one node; what is special to it wins over what is said to all.
pub fn read_file_of(
    path: &Path,
    fully_qualified_name: &str,
) -> Result<BTreeMap<String, ParameterValue>, ParameterFileError> {
    let sections = file::read(path)?.into_iter();
    Ok(sections.filter(|s| s.matches(fully_qualified_name)).flat_map(|s| s.parameters).collect())
}

/// The value as it is stored, if the declaration allows it.
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
        return Err(ParameterError::NoSuchChoice { name, value, choices });
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
        let naming = Naming::new("agent_node", &arguments.remaps).unwrap();
        Parameters::new(&naming, &arguments).unwrap()
    }

    #[test]
    fn overrides_win_and_the_last_wins_most() {
        let parameters = parameters("-p episodes:=5 -p episodes:=6 -p other_node:episodes:=7");
        assert_eq!(parameters.declare("episodes", 1000, Descriptor::default()), Ok(6));
        assert_eq!(parameters.declare("seed", 3, Descriptor::default()), Ok(3));
        assert_eq!(parameters.refuse_undeclared(), Ok(()));
    }

    #[test]
    fn bad_values_say_what_would_be_right() {
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
        assert!(message(parameters.refuse_undeclared()).contains("no parameter 'episodes'"));
    }

    #[test]
    fn an_integer_serves_where_a_double_is_declared_but_not_the_other_way() {
        let parameters = parameters("-p rate:=20 -p depth:=1.5");
        assert_eq!(parameters.declare("rate", 0.0, Descriptor::default()), Ok(20.0));
        assert!(parameters.declare("depth", 1, Descriptor::default()).is_err());
    }

    #[test]
    fn read_only_parameters_stay() {
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
    fn several_are_changed_or_none_and_the_listener_hears_of_changes_only() {
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
        let mut heard = Vec::new();
        while let Ok((name, value)) = listener.try_recv() {
            heard.push((name, value));
        }
        let expected = [("rate", 0.5), ("share", 0.5), ("rate", 0.75)];
        assert_eq!(heard, expected.map(|(name, value)| (name.to_owned(), double(value))));
    }

    #[test]
    fn a_check_of_its_own_refuses_with_its_reason() {
        let pair = |value: &ParameterValue| match value {
            ParameterValue::DoubleArray(numbers) if numbers.len() != 2 => {
                Err(format!("{} numbers are no pair", numbers.len()))
            }
            _ => Ok(()),
        };
        let descriptor = || Descriptor::dynamic("").check(pair);
        let refused = parameters("-p place:=[1.0]").declare("place", vec![0.0, 0.0], descriptor());
        let message = "parameter 'place' is the list [1.0]: 1 numbers are no pair";
        assert_eq!(refused.unwrap_err().to_string(), message);

        let parameters = parameters("");
        parameters.declare("place", vec![0.0, 0.0], descriptor()).unwrap();
        let place = |numbers: &[f64]| ParameterValue::DoubleArray(numbers.to_vec());
        assert_eq!(parameters.set("place", place(&[1.0])).unwrap_err().to_string(), message);
        assert_eq!(parameters.get("place"), Some(vec![0.0, 0.0]));
        assert_eq!(parameters.set("place", place(&[1.0, 2.0])), Ok(()));
        assert_eq!(parameters.get("place"), Some(vec![1.0, 2.0]));
    }
}
