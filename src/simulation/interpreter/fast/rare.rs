//! The functions for rare words, as pointers, so that a WebAssembly module without rare programs does not include
//! them.

use crate::simulation::interpreter::state::Rare;

/// All of these functions.
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

/// No such function; the interpreter notes that the program needs one.
pub(crate) const NONE: Rare = Rare {
    siemens_statement: |interpreter, _, _, _| interpreter.needs_rare_functions = true,
    siemens_g_word: |interpreter, _, _, _, _, _| interpreter.needs_rare_functions = true,
    siemens_act: |interpreter, _, _| interpreter.needs_rare_functions = true,
    // Only Siemens statements have an effect after a move.
    siemens_after_move: |_, _| {},
    spline_to: |interpreter, _, _, _| interpreter.needs_rare_functions = true,
    end_nurbs: |interpreter, _, _| interpreter.needs_rare_functions = true,
};
