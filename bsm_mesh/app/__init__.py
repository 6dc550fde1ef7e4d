"""The application: model file, command line, progress, pictures, load and save."""
