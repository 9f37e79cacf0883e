"""A cone that gets narrower as the robot gets faster."""


def half_angle(speed: float, widest: float, narrowest: float, fastest: float) -> float:
    """beta(v) = beta_max + (beta_min - beta_max) clip(v/v_max, 0, 1), rad; speeds in m/s.

    A slow robot sees little of a place, and fills it with the whole cone; a fast one sweeps it with the axis
    (Murphy, Gomes & Hershberger, in Introduction to AI Robotics, 11.6).
    """
    return widest + (narrowest - widest) * min(max(speed / fastest, 0.0), 1.0)
