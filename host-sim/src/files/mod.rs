//! Files: channel data, delayed data, lines, images. Written whole or not at all.
