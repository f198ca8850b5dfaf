"""Many pairs by many methods: what a collection holds, and sweeps over it that can be stopped and taken up again."""
