"""The teaching page in a real Chromium, drawn without a GPU. Where WebGL 2 does not work, these tests fail."""
