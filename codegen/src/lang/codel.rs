//! Codels as functions: prototypes and calls.

use dotgen_analysis::model::{Codel, ComponentId, ParamDir, ParamSource};

use super::{Anchor, LangError, LangResult, Language, Mapper, PassingMode, param_types, text};

impl Mapper<'_> {
    /// The prototype of a codel. `separator` is between the return type and the name; `location` puts a
    /// `#line` mark in front.
    ///
    /// The lines are cut as in GenoM3, which loses a character where an argument holds a comma (C++
    /// templates): [`Mapper::prototype`] does not.
    ///
    /// # Errors
    /// Fails for parameters whose type the language cannot declare, and in Tcl.
    pub fn signature(
        &self,
        component: ComponentId,
        codel: &Codel,
        separator: &str,
        location: bool,
    ) -> LangResult {
        let result = self.event_type()?;
        let arguments = self.codel_arguments(component, codel)?;
        let symbol = self.cname(&codel.name)?;
        let prefix = " ".repeat(symbol.chars().count() + 1);
        let call = format!("{symbol}({})", arguments.join(", "));
        let mut out = String::new();
        if location {
            out += &self.line_mark(self.places.place(codel.src, Anchor::First));
            out.push('\n');
        }
        out += result;
        out += separator;
        out += &text::wrap(&call, &prefix, ",", 70);
        Ok(out)
    }

    /// The prototype of a codel in valid C or C++, cut into lines between arguments only.
    ///
    /// # Errors
    /// Fails like [`Mapper::signature`].
    pub fn prototype(&self, component: ComponentId, codel: &Codel, separator: &str) -> LangResult {
        let arguments = self.codel_arguments(component, codel)?;
        let symbol = self.cname(&codel.name)?;
        let start = symbol.chars().count() + 1;
        let mut out = format!("{}{separator}{symbol}(", self.event_type()?);
        // Aligned with the first argument, for any start of the name's line.
        let line = out.rfind('\n').map_or(0, |end| end + 1);
        let indent = out[line..].chars().count();
        let mut column = start;
        for (index, argument) in arguments.iter().enumerate() {
            let last = index + 1 == arguments.len();
            let width = argument.chars().count() + 1;
            if index > 0 {
                // As in `signature`: a comma may follow the last column.
                if column + 1 + width > if last { 70 } else { 71 } {
                    out.push('\n');
                    out += &" ".repeat(indent);
                    column = start;
                } else {
                    out.push(' ');
                    column += 1;
                }
            }
            out += argument;
            out.push(if last { ')' } else { ',' });
            column += width;
        }
        Ok(out)
    }

    fn event_type(&self) -> Result<&'static str, LangError> {
        match self.language {
            Language::C => Ok("genom_event"),
            Language::Cxx => Ok("genom::event"),
            Language::Tcl => self.unsupported("signature"),
        }
    }

    fn codel_arguments(
        &self,
        component: ComponentId,
        codel: &Codel,
    ) -> Result<Vec<String>, LangError> {
        let mut arguments = Vec::with_capacity(codel.params.len() + 1);
        for param in &codel.params {
            let remote = matches!(param.source, ParamSource::Port(_) | ParamSource::Remote(_));
            let passing = match param.dir {
                _ if remote => PassingMode::Value,
                ParamDir::In => PassingMode::Value,
                ParamDir::Out | ParamDir::Inout => PassingMode::Reference,
                ParamDir::Local => {
                    arguments.push(String::new());
                    continue;
                }
            };
            let ty = param_types(self.spec, component, param).1;
            arguments.push(self.argument(ty, passing, &param.name)?);
        }
        match self.language {
            Language::C => arguments.push("const genom_context self".into()),
            _ if arguments.is_empty() => arguments.push("void".into()),
            _ => {}
        }
        Ok(arguments)
    }

    /// A call of a codel with the given arguments.
    ///
    /// # Errors
    /// Fails for a wrong number of arguments, and in Tcl.
    pub(crate) fn invoke(
        &self,
        component: ComponentId,
        codel: &Codel,
        arguments: &[String],
    ) -> LangResult {
        let expected = match self.language {
            Language::C => codel.params.len() + 1,
            Language::Cxx => codel.params.len(),
            Language::Tcl => return self.unsupported("invoke"),
        };
        if arguments.len() != expected {
            return Err(LangError::fatal(format!(
                "wrong # arguments in \"{} invoke\":\n{}\nexpecting:\n{}",
                codel.name,
                arguments.join(", "),
                self.signature(component, codel, " ", false)?
            )));
        }
        let symbol = self.cname(&codel.name)?;
        Ok(format!("{symbol}({})", arguments.join(", ")))
    }
}
