//! What drives and disturbs a plant: sums of sinusoids, initial states, noise
