//! From mismatch to findings: locate, screen, confirm, prove
