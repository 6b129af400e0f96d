//! The method and its options, as [`Method`] lists them: a new one appears here by itself.

use super::known::region;
use clap::builder::{PossibleValue, PossibleValuesParser, ValueParser};
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use vibrissa::config::{Region, Setting, SettingValue, Slot};
use vibrissa::localizer::Method;

/// The name of the option that chooses the method.
const METHOD: &str = "method";

/// The method that was chosen, with its options.
#[derive(Clone, Debug, Default)]
pub(crate) struct MethodArgs {
    /// The method; ranges are not checked yet.
    pub(super) method: Method,
    /// The other methods with what was given for them: it is checked, although it is not used.
    others: Vec<Method>,
    /// Options that were given but belong to other methods.
    pub(super) unused: Vec<String>,
}

impl clap::Args for MethodArgs {
    fn augment_args(command: Command) -> Command {
        let words = Method::all().map(|method| PossibleValue::new(method.name()).help(method.summary()));
        let method = Arg::new(METHOD).long(METHOD).value_name("METHOD").help("The estimator");
        let method = method.value_parser(PossibleValuesParser::new(words)).default_value(Method::default().name());
        let mut methods = Method::all();
        let mut known = Vec::new();
        let mut command = command.arg(method);
        for own in &mut methods {
            for setting in own.settings() {
                if !known.contains(&setting.name) {
                    known.push(setting.name);
                    command = command.arg(argument(&setting));
                }
            }
        }
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for MethodArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let refused = |error: vibrissa::Error| clap::Error::raw(clap::error::ErrorKind::InvalidValue, error);
        let chosen = matches.get_one::<String>(METHOD).map(|name| Method::named(name)).transpose();
        let chosen = chosen.map_err(refused)?.unwrap_or_default();
        let mut args = Self { method: chosen, ..Self::default() };
        for mut method in Method::all() {
            let given: Vec<_> = method.settings().iter().filter_map(|s| Some((s.name, given(matches, s)?))).collect();
            for (name, value) in given {
                method.set(name, value).map_err(refused)?;
                let flag = format!("--{}", dashed(name));
                if !args.method.has(name) && !args.unused.contains(&flag) {
                    args.unused.push(flag);
                }
            }
            if method.name() == chosen.name() { args.method = method } else { args.others.push(method) }
        }
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl MethodArgs {
    /// The method that was chosen.
    pub(in crate::commands) fn method(&self) -> &Method {
        &self.method
    }

    /// Checks every option that was given, used or not.
    pub(in crate::commands) fn check(&self) -> vibrissa::Result<()> {
        self.method.check()?;
        self.others.iter().try_for_each(Method::check)
    }
}

/// The name as the command line has it.
fn dashed(name: &str) -> String {
    name.replace('_', "-")
}

/// The option of the command line, its default from the library.
fn argument(setting: &Setting<'_>) -> Arg {
    let parser: ValueParser = match &setting.field {
        Slot::Number(_) | Slot::OptionalNumber(..) => clap::value_parser!(f64).into(),
        Slot::Count(_) => clap::value_parser!(usize).into(),
        Slot::Region(_) => region.into(),
        Slot::Choice(word) => {
            let words = word.words().iter().map(|(word, meaning)| PossibleValue::new(*word).help(*meaning));
            PossibleValuesParser::new(words).into()
        }
    };
    let default = setting.shown().map_or_else(String::new, |shown| format!(" [default: {shown}]"));
    Arg::new(setting.name)
        .long(dashed(setting.name))
        .value_name(setting.value_name)
        .value_parser(parser)
        .allow_hyphen_values(matches!(setting.field, Slot::Region(_)))
        .help_heading(heading(setting.name))
        .help(format!("{}{default}", setting.help))
}

/// What was given for an option.
fn given(matches: &ArgMatches, setting: &Setting<'_>) -> Option<SettingValue> {
    match &setting.field {
        Slot::Number(_) | Slot::OptionalNumber(..) => matches.get_one(setting.name).copied().map(SettingValue::Number),
        Slot::Count(_) => matches.get_one(setting.name).copied().map(SettingValue::Count),
        Slot::Region(_) => matches.get_one::<Region>(setting.name).copied().map(SettingValue::Region),
        Slot::Choice(_) => matches.get_one(setting.name).cloned().map(SettingValue::Choice),
    }
}

/// Under which heading help lists an option: that of the methods that have it.
fn heading(option: &str) -> String {
    match Method::having(option).as_slice() {
        all if all.len() == Method::all().len() => "Options of all methods".to_owned(),
        [one] => format!("Options of the {one} method"),
        several => format!("Options of the {} method", several.join(" and the ")),
    }
}
