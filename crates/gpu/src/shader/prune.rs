//! Drops what a variant never does.
//!
//! A shader has code for every value of its overrides. Drivers inline every call before they find out which branches
//! can be taken, and so compile all of it as often as it is called. Here the branches go before the driver sees them.

use std::collections::HashMap;

use naga::compact::{KeepUnused, compact};
use naga::{
    Arena, BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, Module, Statement,
    UnaryOperator,
};

/// Drops the branches of a module without overrides that constant conditions exclude, and whatever only they use.
pub(super) fn prune(module: &mut Module) {
    let mut functions = std::mem::take(&mut module.functions);
    let mut results = HashMap::new();
    // Functions stand behind those that they call.
    for (handle, function) in functions.iter_mut() {
        if let Some(result) = prune_function(module, &results, function) {
            results.insert(handle, result);
        }
    }
    let mut entries = std::mem::take(&mut module.entry_points);
    for entry in &mut entries {
        prune_function(module, &results, &mut entry.function);
    }
    (module.functions, module.entry_points) = (functions, entries);
    compact(module, KeepUnused::No);
}

/// Returns the constant that the function returns, if it does.
fn prune_function(
    module: &Module,
    results: &HashMap<Handle<Function>, Literal>,
    function: &mut Function,
) -> Option<Literal> {
    // Names would keep expressions of the branches that go.
    function.named_expressions.clear();
    let body = std::mem::take(&mut function.body);
    let (expressions, locals) = (&function.expressions, &function.local_variables);
    let mut pruner = Pruner { module, results, expressions, locals, stored: HashMap::new() };
    let body = pruner.block(body);
    let result = match body.last() {
        Some(Statement::Return { value: Some(value) }) if !body.iter().any(is_nested) => pruner.constant(*value),
        _ => None,
    };
    function.body = body;
    result
}

/// Knowledge of a function's expressions.
struct Pruner<'a> {
    module: &'a Module,
    /// Constants that functions return.
    results: &'a HashMap<Handle<Function>, Literal>,
    expressions: &'a Arena<Expression>,
    locals: &'a Arena<LocalVariable>,
    /// Values of the variables without names, `None` for those that are no constants. naga makes one such variable of
    /// each `&&` and `||`, stores to it in both branches, and reads it after them.
    stored: HashMap<Handle<LocalVariable>, Option<Literal>>,
}

impl Pruner<'_> {
    fn block(&mut self, block: Block) -> Block {
        let mut out = Block::new();
        for (statement, span) in block.span_into_iter() {
            match self.statement(statement) {
                Kept::One(statement) => out.push(statement, span),
                Kept::All(mut taken) => out.append(&mut taken),
            }
            // Nothing may follow a branch that returns, once it is all that is left.
            if out.last().is_some_and(ends) {
                break;
            }
        }
        out
    }

    fn statement(&mut self, statement: Statement) -> Kept {
        Kept::One(match statement {
            Statement::If { condition, accept, reject } => match self.constant(condition) {
                Some(Literal::Bool(taken)) => return Kept::All(self.block(if taken { accept } else { reject })),
                _ => Statement::If { condition, accept: self.block(accept), reject: self.block(reject) },
            },
            Statement::Block(block) => Statement::Block(self.block(block)),
            Statement::Switch { selector, mut cases } => {
                for case in &mut cases {
                    case.body = self.block(std::mem::take(&mut case.body));
                }
                Statement::Switch { selector, cases }
            }
            Statement::Loop { body, continuing, break_if } => {
                Statement::Loop { body: self.block(body), continuing: self.block(continuing), break_if }
            }
            Statement::Store { pointer, value } => {
                if let Expression::LocalVariable(variable) = self.expressions[pointer] {
                    let value = self.constant(value);
                    let held = self.stored.entry(variable).or_insert(value);
                    *held = held.filter(|held| Some(*held) == value);
                }
                statement
            }
            other => other,
        })
    }

    /// Returns the value of an expression that is the same whenever it is reached.
    fn constant(&self, expression: Handle<Expression>) -> Option<Literal> {
        use BinaryOperator::{And, Equal, InclusiveOr, LogicalAnd, LogicalOr, NotEqual};
        match self.expressions[expression] {
            Expression::Literal(value) => Some(value),
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[constant].init] {
                    Expression::Literal(value) => Some(value),
                    _ => None,
                }
            }
            Expression::CallResult(function) => self.results.get(&function).copied(),
            Expression::Load { pointer } => match self.expressions[pointer] {
                Expression::LocalVariable(variable) if self.locals[variable].name.is_none() => {
                    self.stored.get(&variable).copied().flatten()
                }
                _ => None,
            },
            Expression::Select { condition, accept, reject } => match self.constant(condition)? {
                Literal::Bool(taken) => self.constant(if taken { accept } else { reject }),
                _ => None,
            },
            Expression::Unary { op: UnaryOperator::LogicalNot, expr } => match self.constant(expr)? {
                Literal::Bool(value) => Some(Literal::Bool(!value)),
                _ => None,
            },
            Expression::Binary { op, left, right } => match op {
                Equal | NotEqual => {
                    let (left, right) = (self.constant(left)?, self.constant(right)?);
                    Some(Literal::Bool((left == right) == (op == Equal)))
                }
                // One side is enough where it decides.
                And | LogicalAnd | InclusiveOr | LogicalOr => {
                    let decides = Literal::Bool(matches!(op, InclusiveOr | LogicalOr));
                    match [left, right].map(|side| self.constant(side)) {
                        [Some(side), _] | [_, Some(side)] if side == decides => Some(decides),
                        [Some(left @ Literal::Bool(_)), Some(right)] if left == right => Some(left),
                        _ => None,
                    }
                }
                _ => None,
            },
            _ => None,
        }
    }
}

/// Remainder of a statement.
enum Kept {
    One(Statement),
    /// The branch that is taken.
    All(Block),
}

fn is_nested(statement: &Statement) -> bool {
    use Statement::{Block, If, Loop, Switch};
    matches!(statement, Block(_) | If { .. } | Loop { .. } | Switch { .. })
}

/// Returns `true` if nothing behind a statement is reached.
fn ends(statement: &Statement) -> bool {
    let all_end = |block: &Block| block.last().is_some_and(ends);
    match statement {
        Statement::Return { .. } | Statement::Kill | Statement::Break | Statement::Continue => true,
        Statement::Block(block) => all_end(block),
        Statement::If { accept, reject, .. } => all_end(accept) && all_end(reject),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use naga::back::pipeline_constants::process_overrides;
    use naga::valid::{Capabilities, ValidationFlags, Validator};

    use super::*;

    /// Names of the functions that are left, and the number of branches.
    fn left(text: &str, overrides: &[(&str, f64)]) -> (Vec<String>, usize) {
        let module = naga::front::wgsl::parse_str(text).expect("WGSL");
        let validator = || Validator::new(ValidationFlags::all(), Capabilities::all());
        let info = validator().validate(&module).expect("valid");
        let values = overrides.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let mut module = process_overrides(&module, &info, None, &values).expect("values").0.into_owned();
        prune(&mut module);
        validator().validate(&module).expect("still valid");
        let names = module.functions.iter().filter_map(|(_, function)| function.name.clone()).collect();
        let bodies = module.functions.iter().map(|(_, function)| &function.body);
        (names, bodies.chain(module.entry_points.iter().map(|entry| &entry.function.body)).map(branches).sum())
    }

    fn branches(block: &Block) -> usize {
        let within = |statement: &Statement| match statement {
            Statement::If { accept, reject, .. } => 1 + branches(accept) + branches(reject),
            Statement::Block(block) => branches(block),
            Statement::Loop { body, continuing, .. } => branches(body) + branches(continuing),
            Statement::Switch { cases, .. } => cases.iter().map(|case| branches(&case.body)).sum(),
            _ => 0,
        };
        block.iter().map(within).sum()
    }

    /// A shader whose entry point has these lines.
    fn shader(lines: &str) -> String {
        format!(
            "override A: u32 = 0u;\n@group(0) @binding(0) var<storage, read_write> data: array<f32>;\n\
             fn heavy() -> f32 {{ return data[3] * 2.0; }}\n\
             fn has_a() -> bool {{ if A == 1u {{ return true; }} return false; }}\n\
             fn stride() -> u32 {{ return select(1u, 2u, A == 1u); }}\n\
             @compute @workgroup_size(1) fn main() {{ {lines} }}"
        )
    }

    #[test]
    fn what_an_override_excludes_is_gone_with_all_that_it_calls() {
        for lines in [
            "if A == 1u { data[0] = heavy(); }",
            "if has_a() { data[0] = heavy(); }",
            "if has_a() && data[1] > 0.0 { data[0] = heavy(); }",
            "if data[1] > 0.0 && has_a() { data[0] = heavy(); }",
            "if !(!has_a() || data[1] > 0.0) { data[0] = heavy(); }",
            "if has_a() & (data[1] > 0.0) { data[0] = heavy(); }",
            "if !(!has_a() | (data[1] > 0.0)) { data[0] = heavy(); }",
            "if stride() == 2u { data[0] = heavy(); }",
            "if stride() != 1u { data[0] = heavy(); } else { data[0] = 1.0; }",
            "if !has_a() { return; } data[0] = heavy();",
            "for (var i = 0u; i < 3u; i++) { if !has_a() { continue; } data[i] = heavy(); }",
            "switch u32(data[1]) { case 1u: { if has_a() { data[0] = heavy(); } } default: {} }",
            "{ { if has_a() { data[0] = heavy(); } } }",
        ] {
            let of = |a: f64| left(&shader(lines), &[("A", a)]).0.contains(&"heavy".to_owned());
            assert_eq!((of(0.0), of(1.0)), (false, true), "{lines}");
        }
    }

    #[test]
    fn what_the_data_decide_stays() {
        for (a, lines, expected) in [
            (0.0, "if data[1] > 0.0 { data[0] = heavy(); }", 1),
            (0.0, "var on: bool; if data[1] > 0.0 { on = true; } if on { data[0] = heavy(); }", 2),
            (0.0, "var on = false; if data[1] > 0.0 { on = true; } if on { data[0] = heavy(); }", 2),
            // && and || have a branch of their own.
            (0.0, "if data[1] > 0.0 && data[2] > 0.0 { data[0] = heavy(); }", 2),
            (0.0, "if has_a() || data[2] > 0.0 { data[0] = heavy(); }", 1),
            (0.0, "if data[1] > 0.0 || has_a() { data[0] = heavy(); }", 2),
            (1.0, "if data[1] > 0.0 && has_a() { data[0] = heavy(); }", 2),
            (0.0, "if has_a() | (data[1] > 0.0) { data[0] = heavy(); }", 1),
            (1.0, "if has_a() & (data[1] > 0.0) { data[0] = heavy(); }", 1),
            (0.0, "if data[1] == 0.0 { return; } data[0] = heavy();", 1),
        ] {
            let (names, branches) = left(&shader(lines), &[("A", a)]);
            assert!(names.contains(&"heavy".to_owned()) && branches == expected, "{lines}: {branches}");
        }
    }
}
