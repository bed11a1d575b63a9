//! What few programs need of a run, as functions, so that a module that leaves those programs to another does not carry it.

use crate::simulation::interpreter::state::Rare;

/// All of it.
pub(crate) const ALL: Rare = Rare {
    siemens_statement: |interpreter, block, statement, action| {
        interpreter.siemens_statement(block, statement, action)
    },
    siemens_g_word: |interpreter, block, place, code, word, request| {
        interpreter.siemens_g_word(block, place, code, word, request);
    },
    siemens_act: |interpreter, block, action| interpreter.siemens_act(block, action),
    siemens_after_move: |interpreter, block| interpreter.siemens_after_move(block),
    spline_to: |interpreter, block, spline, end| interpreter.spline_to(block, spline, end),
    end_nurbs: |interpreter, block, code| interpreter.end_nurbs(block, code),
};

/// Nothing of it; the interpreter tells where it was asked for.
pub(crate) const NONE: Rare = Rare {
    siemens_statement: |interpreter, _, _, _| interpreter.needs_rare = true,
    siemens_g_word: |interpreter, _, _, _, _, _| interpreter.needs_rare = true,
    siemens_act: |interpreter, _, _| interpreter.needs_rare = true,
    // Only what Siemens statements asked for before.
    siemens_after_move: |_, _| {},
    spline_to: |interpreter, _, _, _| interpreter.needs_rare = true,
    end_nurbs: |interpreter, _, _| interpreter.needs_rare = true,
};
