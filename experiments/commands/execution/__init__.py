"""Commands that carry plans out."""
