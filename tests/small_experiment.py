"""A small experiment on a plane: the scene and the file."""

SCENE = """\
objects: [{name: table, plane: {size: 0.2}, stiffness: 400, damping: 2}]
mapping: {scale: 0.5}
rates: {plant: 2000.0}
"""
FILE = """\
title: Does a felt force help?
seed: 3
participants: 4
conditions:
  none: {felt: false}
  force: {}
tasks:
  press:
    {scene: table.yaml, path: [[0.0, 0.0, 0.0]], force: 0.6, within: 0.5, dwell: 0.1, time_limit: 2.0, start: 0.002}
familiarisation: 0
repetitions: 1
questionnaires: {tlx: true, preference: true, likert: [{name: trust, words: I trusted what I felt.}]}
measures: [force_error_N, time_s]
"""
