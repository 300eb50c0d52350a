"""Motions of human joints in level walking -> ../motions/*.csv.   Needs numpy.

Sources of the figures below (mean curves of able-bodied adults, every 2 % of the stride, 0 % = initial contact):
  ankle: G. Bovi, M. Rabuffetti, P. Mazzoleni, M. Ferrarin, "A multiple-task gait analysis approach: kinematic,
         kinetic and EMG reference data for healthy young and adult subjects", Gait & Posture 33 (2011) 6-13,
         doi:10.1016/j.gaitpost.2010.08.009; adults, natural speed. Angle from its value at initial contact,
         dorsiflexion positive; moment per kg, plantarflexor positive.
  knee, hip: M. Grimmer, A. Seyfarth, "Mimicking Human-Like Leg Function in Prosthetic Limbs", in: Neuro-Robotics,
         Springer 2014, 105-155, doi:10.1007/978-94-017-8932-5_5; level walking, as read off the figures.
         Velocity and moment per kg, extension positive for both.
Stride time 1.14 s (105 steps/min, natural cadence) is assumed: neither source's mean curve carries a time axis.
Each curve becomes a Fourier series (harmonics 1 to 16, Lanczos sigma factors); derivatives are those of the series, the mean of a
velocity is dropped so that the position is periodic. Torque is the moment the joint's muscles give = what the actuator supplies.
"""
import numpy as np

STRIDE = 1.14  # s
HARMONICS = 16
SAMPLES = 120

#  %   ankle  ankle    knee   knee     hip    hip
#      angle  moment   veloc. moment   veloc. moment
#      deg    N*m/kg   deg/s  N*m/kg   deg/s  N*m/kg
TABLE = np.array([float(x) for x in """
  0    0.00  -0.037   -27.0 -0.302    -8.9  0.426
  2   -2.40  -0.048   -82.8 -0.374   -18.2  0.638
  4   -3.62  -0.051   -95.3 -0.433   -18.6  0.836
  6   -2.62  -0.039   -99.4 -0.335    -3.4  0.860
  8   -0.72  -0.012   -97.9 -0.155    26.6  0.782
 10    1.38   0.029   -85.0  0.062    51.9  0.572
 12    3.13   0.079   -57.4  0.278    66.1  0.389
 14    4.54   0.136   -21.9  0.411    69.0  0.239
 16    5.74   0.196     4.8  0.454    64.9  0.131
 18    6.79   0.259    18.4  0.443    61.6  0.063
 20    7.77   0.324    29.8  0.385    61.3  0.021
 22    8.73   0.392    38.0  0.327    62.0  0.003
 24    9.64   0.463    41.9  0.256    62.1 -0.021
 26   10.42   0.537    47.4  0.172    61.4 -0.047
 28   11.11   0.614    49.6  0.112    57.9 -0.061
 30   11.73   0.697    49.7  0.053    54.6 -0.085
 32   12.42   0.786    49.7 -0.003    51.4 -0.106
 34   13.20   0.881    47.9 -0.048    49.1 -0.124
 36   13.95   0.979    42.2 -0.103    46.6 -0.150
 38   14.60   1.078    32.9 -0.138    45.1 -0.191
 40   15.09   1.171    21.7 -0.169    42.1 -0.226
 42   15.29   1.248    11.6 -0.187    38.9 -0.272
 44   15.15   1.301   -10.6 -0.189    34.4 -0.328
 46   14.53   1.315   -40.4 -0.161    29.7 -0.396
 48   13.18   1.280   -66.7 -0.110    25.7 -0.470
 50   10.96   1.189   -94.8 -0.008    19.6 -0.549
 52    7.53   1.041  -124.8  0.101    10.5 -0.607
 54    2.52   0.850  -153.3  0.196    -2.9 -0.651
 56   -3.78   0.638  -190.5  0.250   -23.2 -0.646
 58   -9.92   0.435  -231.7  0.267   -51.2 -0.580
 60  -14.57   0.264  -274.8  0.218   -90.2 -0.457
 62  -16.95   0.139  -307.7  0.128  -125.6 -0.315
 64  -16.44   0.060  -316.9  0.066  -150.8 -0.183
 66  -13.58   0.018  -288.3  0.040  -160.8 -0.091
 68   -9.77   0.000  -245.2  0.031  -152.7 -0.036
 70   -6.08  -0.006  -168.7  0.026  -130.8 -0.002
 72   -2.93  -0.008   -89.5  0.022  -109.7  0.015
 74   -0.13  -0.008   -19.0  0.010   -90.9  0.018
 76    2.03  -0.008    58.3  0.001   -69.9  0.018
 78    3.56  -0.009   124.8 -0.008   -51.9  0.009
 80    4.76  -0.010   189.1 -0.016   -36.2  0.002
 82    5.47  -0.010   242.8 -0.021   -19.3 -0.013
 84    5.51  -0.011   296.5 -0.025    -0.2 -0.030
 86    4.71  -0.010   336.8 -0.038    23.5 -0.038
 88    3.43  -0.009   364.0 -0.062    46.1 -0.018
 90    2.27  -0.007   369.8 -0.099    55.8  0.036
 92    1.33  -0.005   338.6 -0.147    48.2  0.117
 94    0.61  -0.004   260.3 -0.218    37.6  0.237
 96    0.18  -0.003   158.0 -0.274    26.2  0.335
 98    0.33  -0.004    60.0 -0.291     9.7  0.365
""".split()]).reshape(-1, 7)


def series(column):
    """Complex Fourier coefficients 0..HARMONICS of one column of the table, with sigma factors."""
    c = np.fft.rfft(TABLE[:, column])[: HARMONICS + 1] / len(TABLE)
    k = np.arange(HARMONICS + 1)
    return c * np.sinc(k / (HARMONICS + 6))


def evaluate(c, t, order=0):
    """Derivative `order` (-1 = integral without mean) of the series at times t."""
    k = np.arange(len(c))
    w = 2j * np.pi * k / STRIDE
    f = np.where(k == 0, 0.0 if order else 1.0, w ** order if order >= 0 else 1 / np.where(k == 0, 1, w))
    return np.real(np.exp(np.outer(t, w)) @ (c * f * np.where(k == 0, 1, 2)))


def joint(name, t):
    """Torque per kg, velocity, position, acceleration; positive = plantarflexion (ankle), extension (knee, hip)."""
    if name == "ankle":
        angle = series(1) * -np.pi / 180
        return evaluate(series(2), t), evaluate(angle, t, 1), evaluate(angle, t), evaluate(angle, t, 2)
    velocity = series({"knee": 3, "hip": 5}[name]) * np.pi / 180
    moment = series({"knee": 4, "hip": 6}[name])
    velocity[0] = 0
    return evaluate(moment, t), evaluate(velocity, t), evaluate(velocity, t, -1), evaluate(velocity, t, 1)


SOURCE = {
    "ankle": "Bovi et al., Gait & Posture 33 (2011) 6-13, adults at natural speed, mean angle and moment",
    "knee": "Grimmer & Seyfarth, in Neuro-Robotics, Springer 2014, 105-155, level walking, mean velocity and moment",
    "hip": "Grimmer & Seyfarth, in Neuro-Robotics, Springer 2014, 105-155, level walking, mean velocity and moment",
}


def write(file, name, kilograms, what):
    t = np.linspace(0, STRIDE, SAMPLES + 1)
    torque, velocity, position, acceleration = joint(name, t)
    rows = np.column_stack([t, torque * kilograms, velocity, position, acceleration])
    rows[-1, 1:] = rows[0, 1:]
    direction = "plantarflexion" if name == "ankle" else "extension"
    with open(f"../motions/{file}.csv", "w") as out:
        out.write(f"# {SOURCE[name]}\n# {what}\n")
        out.write(f"# Positive = {direction}; stride time 1.14 s (105 steps/min); Fourier series of 16 harmonics, see make/gait.py.\n")
        out.write("time [s], torque [N*m], velocity [rad/s], position [rad], acceleration [rad/s^2]\n")
        for row in rows:
            out.write(", ".join(f"{x:.7g}" if abs(x) > 1e-9 else "0" for x in row) + "\n")


if __name__ == "__main__":
    write("ankle_walking_75kg", "ankle", 75, "Torque = moment per kg x 75 kg body mass, all of it supplied by the actuator.")
    write("knee_walking_75kg", "knee", 75, "Torque = moment per kg x 75 kg body mass, all of it supplied by the actuator.")
    write("hip_assistance_30_percent", "hip", 0.3 * 75, "Torque = 30 % of the moment of a 75 kg wearer, in phase with it.")
    write("hip_walking_40kg", "hip", 40, "Torque = moment per kg x 40 kg, a humanoid walking with the human moment and motion.")
    write("knee_walking_40kg", "knee", 40, "Torque = moment per kg x 40 kg, a humanoid walking with the human moment and motion.")
