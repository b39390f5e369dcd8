//! Every parameter, from TOML and from the command line.
