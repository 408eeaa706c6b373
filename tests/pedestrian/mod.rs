mod align;
mod files;
mod filter;
mod grid;
mod hex;
mod mapping;
mod random;
