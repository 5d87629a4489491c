//! Declaration of settings: each is written once, beside the stage that reads it.
//!
//! A declaration gives a setting's sentence, name, type, default, unit and limits.  `settings!`
//! makes the struct of it, its defaults, its checks and its [`Section`]; `choices!` does the same
//! for the values of an enumerated setting.  `Config::schema` lists all sections, from which the
//! Python classes and the settings' reference page are generated.

use std::fmt::{Display, Formatter, Result as FormatResult};

use serde::{Serialize, Serializer};

use crate::error::ConfigError;
use crate::limits::Limits;

/// The settings of one stage, or of one kind of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Section {
    /// Name of the table in a TOML file.
    pub name: &'static str,
    /// Value of `kind` that selects these settings, where a table has several kinds.
    pub kind: Option<&'static str>,
    /// Name of the Rust struct.
    pub class: &'static str,
    /// What the stage does; the first line is a summary.
    pub doc: String,
    /// The settings in their order.
    pub settings: Vec<Setting>,
}

/// One setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Its name in the section.
    pub name: &'static str,
    /// What it is.
    pub doc: String,
    /// The type of its values.
    pub value: ValueType,
    /// Its default.
    pub default: Literal,
    /// Its unit; empty for a ratio, a count and whatever is no number.
    pub unit: &'static str,
    /// Limits of the number, or of each number of a vector.
    pub limits: Option<Limits>,
}

/// The type of a setting's values.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ValueType {
    /// A number.
    Number,
    /// True or false.
    Flag,
    /// Three numbers.
    Vector,
    /// Three rows of three numbers.
    Matrix,
    /// One of several words.
    Choice {
        /// Name of the Rust enum.
        name: &'static str,
        /// The words.
        values: &'static [Choice],
    },
    /// Any number of values of a type.
    List(Box<ValueType>),
    /// A value of a type, or none.
    Optional(Box<ValueType>),
}

/// One value of an enumerated setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// The word that stands for it in files.
    pub value: &'static str,
    /// What it means.
    #[serde(serialize_with = "as_trimmed")]
    pub doc: &'static str,
}

/// A value as it is written in a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Literal {
    /// No value.
    Absent,
    /// True or false.
    Flag(bool),
    /// A number.
    Number(f64),
    /// A word.
    Word(&'static str),
    /// Several values.
    List(Vec<Literal>),
}

impl Literal {
    fn is_within(&self, limits: Limits) -> bool {
        match self {
            Self::Number(number) => limits.contains(*number),
            Self::List(values) => values.iter().all(|value| value.is_within(limits)),
            Self::Absent | Self::Flag(_) | Self::Word(_) => true,
        }
    }
}

impl Display for Literal {
    fn fmt(&self, text: &mut Formatter<'_>) -> FormatResult {
        match self {
            Self::Absent => text.write_str("none"),
            Self::Flag(flag) => write!(text, "{flag}"),
            Self::Number(number) => write!(text, "{number}"),
            Self::Word(word) => text.write_str(word),
            Self::List(values) => {
                let values: Vec<_> = values.iter().map(ToString::to_string).collect();
                write!(text, "[{}]", values.join(", "))
            }
        }
    }
}

/// A type that a setting may have.
pub(crate) trait Value {
    fn value_type() -> ValueType;
    fn literal(&self) -> Literal;
}

impl Value for f64 {
    fn value_type() -> ValueType {
        ValueType::Number
    }

    fn literal(&self) -> Literal {
        Literal::Number(*self)
    }
}

impl Value for bool {
    fn value_type() -> ValueType {
        ValueType::Flag
    }

    fn literal(&self) -> Literal {
        Literal::Flag(*self)
    }
}

impl Value for [f64; 3] {
    fn value_type() -> ValueType {
        ValueType::Vector
    }

    fn literal(&self) -> Literal {
        Literal::List(self.iter().map(Value::literal).collect())
    }
}

impl Value for [[f64; 3]; 3] {
    fn value_type() -> ValueType {
        ValueType::Matrix
    }

    fn literal(&self) -> Literal {
        Literal::List(self.iter().map(Value::literal).collect())
    }
}

impl<V: Value> Value for Vec<V> {
    fn value_type() -> ValueType {
        ValueType::List(V::value_type().into())
    }

    fn literal(&self) -> Literal {
        Literal::List(self.iter().map(Value::literal).collect())
    }
}

impl<V: Value> Value for Option<V> {
    fn value_type() -> ValueType {
        ValueType::Optional(V::value_type().into())
    }

    fn literal(&self) -> Literal {
        self.as_ref().map_or(Literal::Absent, Value::literal)
    }
}

/// Checks every number of a setting against its limits.
pub(crate) fn check(
    key: &'static str,
    value: &impl Value,
    unit: &'static str,
    limits: Limits,
) -> Result<(), ConfigError> {
    let value = value.literal();
    if value.is_within(limits) {
        return Ok(());
    }
    let expected = limits.with_unit(unit).into();
    Err(ConfigError::OutOfRange { key, value: value.to_string(), expected })
}

/// The text of a documentation comment.
pub(crate) fn text(doc: &str) -> String {
    let lines: Vec<_> = doc.lines().map(str::trim).collect();
    lines.join("\n").trim().to_owned()
}

fn as_trimmed<S: Serializer>(doc: &&'static str, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(doc.trim())
}

/// Declares the settings of a section:
///
/// ```text
/// settings! {
///     /// What the stage does.
///     pub struct StageConfig: "stage", also consistent {
///         /// One sentence.
///         name: type = default, "unit", limits;
///         ...
///     }
/// }
/// ```
///
/// `validate` checks each setting, then calls the method after `also`, which is written by hand and
/// checks settings against each other.  Unit and limits are left out where a setting is no number.
macro_rules! settings {
    (
        $(#[doc = $doc:literal])+
        $vis:vis struct $class:ident: $section:literal $(, also $also:ident)? {
            $(
                $(#[doc = $sentence:literal])+
                $name:ident: $type:ty = $default:expr $(, $unit:literal, $limits:expr)?;
            )+
        }
    ) => {
        $(#[doc = $doc])+
        #[derive(Clone, Debug, PartialEq, ::serde::Serialize, ::serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        $vis struct $class {
            $(
                $(#[doc = $sentence])+
                #[doc = ""]
                #[doc = concat!("Default: `", stringify!($default), "`" $(, " ", $unit)?)]
                $vis $name: $type,
            )+
        }

        impl Default for $class {
            fn default() -> Self {
                Self { $($name: $default),+ }
            }
        }

        impl $class {
            /// Checks every setting.
            ///
            /// # Errors
            /// [`ConfigError`](crate::error::ConfigError) with the first setting that makes no
            /// sense, its value and what is allowed.
            $vis fn validate(&self) -> Result<(), crate::error::ConfigError> {
                $({
                    let key = concat!($section, ".", stringify!($name));
                    let limits = [$($limits)?].first().copied();
                    let limits = limits.unwrap_or($crate::limits::Limits::Finite);
                    $crate::settings::check(key, &self.$name, concat!($($unit)?), limits)?;
                })+
                $(self.$also()?;)?
                Ok(())
            }

            /// The settings with their defaults, units and limits.
            #[must_use]
            $vis fn schema() -> $crate::settings::Section {
                let defaults = Self::default();
                $crate::settings::Section {
                    name: $section,
                    kind: None,
                    class: stringify!($class),
                    doc: $crate::settings::text(concat!($($doc, "\n"),+)),
                    settings: vec![$(
                        $crate::settings::Setting {
                            name: stringify!($name),
                            doc: $crate::settings::text(concat!($($sentence, "\n"),+)),
                            value: <$type as $crate::settings::Value>::value_type(),
                            default: $crate::settings::Value::literal(&defaults.$name),
                            unit: concat!($($unit)?),
                            limits: [$($limits)?].first().copied(),
                        }
                    ),+],
                }
            }
        }
    };
}

/// Declares the values of an enumerated setting, each with its word in files; the first is the
/// default.
macro_rules! choices {
    (
        $(#[doc = $doc:literal])+
        $vis:vis enum $name:ident {
            $(#[doc = $first_doc:literal])+
            $first:ident = $first_value:literal,
            $(
                $(#[doc = $choice_doc:literal])+
                $choice:ident = $value:literal,
            )*
        }
    ) => {
        $(#[doc = $doc])+
        #[derive(
            Clone, Copy, Debug, Default, PartialEq, Eq, ::serde::Serialize, ::serde::Deserialize,
        )]
        #[non_exhaustive]
        $vis enum $name {
            $(#[doc = $first_doc])+
            #[default]
            #[serde(rename = $first_value)]
            $first,
            $(
                $(#[doc = $choice_doc])+
                #[serde(rename = $value)]
                $choice,
            )*
        }

        impl $crate::settings::Value for $name {
            fn value_type() -> $crate::settings::ValueType {
                use $crate::settings::{Choice, ValueType};
                ValueType::Choice {
                    name: stringify!($name),
                    values: &[
                        Choice { value: $first_value, doc: concat!($($first_doc),+) },
                        $(Choice { value: $value, doc: concat!($($choice_doc),+) },)*
                    ],
                }
            }

            fn literal(&self) -> $crate::settings::Literal {
                $crate::settings::Literal::Word(match self {
                    Self::$first => $first_value,
                    $(Self::$choice => $value,)*
                })
            }
        }
    };
}

pub(crate) use {choices, settings};

#[cfg(test)]
mod tests {
    use super::*;

    choices! {
        /// A colour.
        enum Colour {
            /// Of blood.
            Red = "red",
            /// Of the sky
            /// by day.
            SkyBlue = "sky-blue",
        }
    }

    settings! {
        /// A stage.
        ///
        /// Its details.
        struct StageConfig: "stage", also consistent {
            /// A length.
            length: f64 = 2.0, "m", Limits::Between(0.5, 10.0);
            /// Its direction.
            direction: Option<[f64; 3]> = None, "", Limits::Finite;
            /// Its colours.
            colours: Vec<Colour> = vec![Colour::SkyBlue];
        }
    }

    impl StageConfig {
        fn consistent(&self) -> Result<(), ConfigError> {
            let bare = self.colours.is_empty();
            if bare { Err(ConfigError::Inconsistent("no colour".into())) } else { Ok(()) }
        }
    }

    fn message(settings: &StageConfig) -> String {
        settings.validate().unwrap_err().to_string()
    }

    #[test]
    fn a_declaration_gives_defaults_and_checks() {
        let valid = StageConfig::default();
        assert_eq!((valid.length, &valid.direction), (2.0, &None));
        assert_eq!(valid.validate(), Ok(()));
        let long = StageConfig { length: 11.0, ..valid.clone() };
        assert_eq!(message(&long), "stage.length = 11: expected between 0.5 and 10 m");
        let nan = StageConfig { direction: Some([0.0, f64::NAN, 1.0]), ..valid.clone() };
        assert_eq!(message(&nan), "stage.direction = [0, NaN, 1]: expected a finite number");
        assert_eq!(message(&StageConfig { colours: vec![], ..valid }), "no colour");
    }

    #[test]
    fn a_declaration_gives_its_schema() {
        let section = StageConfig::schema();
        assert_eq!((section.name, section.class), ("stage", "StageConfig"));
        assert_eq!(section.doc, "A stage.\n\nIts details.");
        let [length, direction, colours] = &section.settings[..] else { panic!("{section:?}") };
        assert_eq!((length.unit, length.limits), ("m", Some(Limits::Between(0.5, 10.0))));
        assert_eq!(direction.value, ValueType::Optional(Box::new(ValueType::Vector)));
        assert_eq!(direction.default, Literal::Absent);
        assert_eq!(colours.default, Literal::List(vec![Literal::Word("sky-blue")]));
        let ValueType::List(choice) = &colours.value else { panic!("{colours:?}") };
        let ValueType::Choice { name: "Colour", values: [red, blue] } = **choice else {
            panic!("{choice:?}")
        };
        assert_eq!((red.value, text(red.doc)), ("red", "Of blood.".into()));
        assert_eq!((blue.value, text(blue.doc)), ("sky-blue", "Of the sky by day.".into()));
    }
}
