mod blocks;
mod queries;
