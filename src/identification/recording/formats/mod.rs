//! The formats of machine logs, one reader each, and the parts of tables that readers share.

pub(in crate::identification::recording) mod beckhoff;
pub(in crate::identification::recording) mod columns;
pub(in crate::identification::recording) mod events;
pub(in crate::identification::recording) mod headerless;
pub(in crate::identification::recording) mod layout;
pub(in crate::identification::recording) mod mtconnect;
pub(in crate::identification::recording) mod siemens_recorder;
pub(in crate::identification::recording) mod siemens_trace;
pub(in crate::identification::recording) mod table;
