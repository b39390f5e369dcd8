//! The report: tables, plots, pictures.
