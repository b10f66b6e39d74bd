"""The equations of a scene, one force after the other as its law is printed, and compiled to Python."""
