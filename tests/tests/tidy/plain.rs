//! Rules about plain statements: a variable per `let`, parameters that have names.

use syn::visit::{self, Visit};
use syn::{Expr, FnArg, Local, Pat, Signature};

use crate::files::SourceFile;

/// The findings in a file.
struct Findings<'a> {
    file: &'a SourceFile,
    found: Vec<String>,
}

/// Finds a `let` that destructures a tuple or array literal, and function parameters that are tuple
/// or array patterns, whose values have no name for a caller.
pub fn packed(files: &[SourceFile]) -> Vec<String> {
    let of_file = |file| {
        let mut findings = Findings { file, found: Vec::new() };
        findings.visit_file(&file.syntax());
        findings.found
    };
    files.iter().filter(|file| file.is_rust()).flat_map(of_file).collect()
}

impl<'ast> Visit<'ast> for Findings<'_> {
    fn visit_local(&mut self, local: &'ast Local) {
        let init = local.init.as_ref().filter(|init| init.diverge.is_none());
        let value = init.map(|init| &*init.expr);
        let is_packed = match (without_type(&local.pat), value) {
            (Pat::Tuple(_), Some(Expr::Tuple(values))) => values.elems.len() > 1,
            (Pat::Slice(_), Some(Expr::Array(values))) => values.elems.len() > 1,
            _ => false,
        };
        if is_packed {
            let line = local.let_token.span.start().line;
            self.found.push(self.file.finding(line, "one variable per `let`"));
        }
        visit::visit_local(self, local);
    }

    fn visit_signature(&mut self, function: &'ast Signature) {
        let is_packed = |input: &FnArg| match input {
            FnArg::Typed(input) => matches!(*input.pat, Pat::Tuple(_) | Pat::Slice(_)),
            FnArg::Receiver(_) => false,
        };
        if function.inputs.iter().any(is_packed) {
            let line = function.fn_token.span.start().line;
            self.found.push(self.file.finding(line, "a parameter has a name, or is a struct"));
        }
        visit::visit_signature(self, function);
    }
}

fn without_type(pattern: &Pat) -> &Pat {
    if let Pat::Type(typed) = pattern { &typed.pat } else { pattern }
}
