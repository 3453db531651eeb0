//! What was seen: recordings, their readers, units, gaps and noise
