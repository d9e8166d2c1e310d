// The functions of `tallies` where every hit is wanted.

fn is_settled() -> bool {
    return false;
}

fn is_reported() -> bool {
    return true;
}
