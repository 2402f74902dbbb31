"""Pre-training of the network on random rigs: contacts, contexts, and training."""
