//! The documentation of one `--set` key, for help, completion and error messages.

/// A parameter's documentation: name, values, default and meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParameterDoc {
    /// Its name in `--set`.
    pub name: &'static str,
    /// The values it takes.
    pub values: &'static str,
    /// Its default.
    pub default: &'static str,
    /// What it does.
    pub about: &'static str,
}

impl ParameterDoc {
    /// The documentation of the parameter `name`.
    pub const fn new(
        name: &'static str,
        values: &'static str,
        default: &'static str,
        about: &'static str,
    ) -> ParameterDoc {
        ParameterDoc { name, values, default, about }
    }
}
