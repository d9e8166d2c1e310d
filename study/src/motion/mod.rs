//! Slow slides through contact, and scenes whose answer has a closed form.
