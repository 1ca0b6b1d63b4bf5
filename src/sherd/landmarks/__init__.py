"""Landmarks: files of 3D Slicer, places on a template, carried to specimens, tables of many."""
