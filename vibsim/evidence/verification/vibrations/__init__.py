"""Known vibrations: free and forced, linear and with a spring that acts on one side (V2 to V5, V12)."""
