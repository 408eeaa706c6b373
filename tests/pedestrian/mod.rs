mod align;
mod files;
mod filter;
mod grid;
mod hex;
mod live;
mod mapping;
mod random;
