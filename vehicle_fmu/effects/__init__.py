"""What a rigid motorcycle or bicycle leaves out. Each file declares effects; what is in this folder, the gap workflow tries."""
