"""Pictures of demonstrations, skills and trajectories. Imported only where something is drawn."""
