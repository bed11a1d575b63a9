//! Toolpath → feed plan.
