//! The methods: how a cell's state changes with a reading.

pub mod settings;
