"""A scene of two pairs: each hand palpates its side of one organ."""

TWO = """\
objects: [{shape: organ, triangles: 3000, stiffness: 300, damping: 2}]
pairs:
  right:
    arms:
      leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
      follower: {base: {xyz: [0.060, -0.060, 0.155], rpy_deg: [0, 0, 155]}}
    operator: {palpate: {at: [0.03, -0.012, 0.1], length: 0.01}}
  left:
    arms:
      leader: {model: mtm_left, base: {xyz: [-0.345, 0.243, 0.219], rpy_deg: [0, 0, 20]}}
      follower: {base: {xyz: [-0.120, -0.060, 0.155], rpy_deg: [0, 0, 205]}}
    operator: {palpate: {at: [-0.035, -0.012, 0.1], length: 0.002}}
"""
