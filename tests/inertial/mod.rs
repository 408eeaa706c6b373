mod filter;
mod foot;
mod hand;
mod real;
mod recordings;
mod walker;
