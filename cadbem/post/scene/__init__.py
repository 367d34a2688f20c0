"""Parts that pictures share: a channel in; glass walls, tinted openings, face numbers out."""
