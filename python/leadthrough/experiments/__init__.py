"""Studies: a frozen configuration in, a result out."""
