#!/usr/bin/env python3
"""Writes riccati_benchmark.json: plants, weights and right answers, found in 120 digits from the doubles as they stand there.

The examples are those of P. Benner, A. J. Laub and V. Mehrmann, "A Collection of Benchmark Examples for the Numerical
Solution of Algebraic Riccati Equations II: Discrete-Time Case" (SPC 95_23, TU Chemnitz-Zwickau, 1995), with the numbers of
its second version, DAREX (J. Abels and P. Benner, SLICOT Working Note 1999-16). Needs mpmath."""

import json
import os

import mpmath as mp

mp.mp.dps = 120


def eye(n):
    return [[float(i == j) for j in range(n)] for i in range(n)]


def diagonal(*values):
    return [[v if i == j else 0.0 for j in range(len(values))] for i, v in enumerate(values)]


def weighted(c, weight):
    """C' W C in exact arithmetic, rounded once."""
    c, weight = mp.matrix(c), mp.matrix(weight)
    product = c.T * weight * c
    return [[float(product[i, j]) for j in range(product.cols)] for i in range(product.rows)]


def shift(n):
    return [[float(j == i + 1) for j in range(n)] for i in range(n)]


def numbers(text):
    return [[float(x) for x in line.split()] for line in text.strip().splitlines()]


def symmetric(n, entries):
    """From {(row, column): value}, counted from 1."""
    m = [[0.0] * n for _ in range(n)]
    for (i, j), v in entries.items():
        m[i - 1][j - 1] = m[j - 1][i - 1] = v
    return m


def fixed():
    yield "1.3", "", [[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 2.0], [2.0, 4.0]], eye(1)
    yield ("1.5", "",
           [[0.998, 0.067, 0.0, 0.0], [-0.067, 0.998, 0.0, 0.0], [0.0, 0.0, 0.998, 0.153], [0.0, 0.0, -0.153, 0.998]],
           [[0.0033, 0.02], [0.1, -0.0007], [0.04, 0.0073], [-0.0028, 0.1]],
           symmetric(4, {(1, 1): 1.87, (1, 4): -0.244, (2, 2): 0.744, (2, 3): 0.205, (3, 3): 0.589, (4, 4): 1.048}),
           eye(2))
    yield ("1.6", "",
           numbers("""0.98475 -0.079903 0.0009054 -0.0010765
                      0.041588 0.99899 -0.035855 0.012684
                      -0.54662 0.044916 -0.32991 0.19318
                      2.6624 -0.10045 -0.92455 -0.26325"""),
           numbers("""0.0037112 0.0007361
                      -0.087051 9.3411e-6
                      -1.19844 -0.00041378
                      -3.1927 0.00092535"""),
           diagonal(*[0.01] * 4), eye(2))
    yield ("1.7", "",
           numbers("""-0.6 -2.2 -3.6 -5.400018
                      1 0.6 0.8 3.399982
                      0 1 1.8 3.799982
                      0 0 0 -0.999982"""),
           numbers("1 -1 -1 -1\n0 1 -1 -1\n0 0 1 -1\n0 0 0 1"),
           weighted([[1, 1, 2, 4], [0, 1, 1, 2], [0, 0, 1, 1], [0, 0, 0, 1]],
                    [[2, -1, 0, 0], [-1, 2, -1, 0], [0, -1, 2, 0], [0, 0, 0, 0]]),
           eye(4))
    yield ("1.8", "",
           numbers("""0.95407 0.019643 0.003597 0.000673 0.00019
                      0.40849 0.41317 0.16084 0.044679 0.011971
                      0.12217 0.26326 0.36149 0.1593 0.12383
                      0.041118 0.12858 0.27209 0.21442 0.40976
                      0.001305 0.005808 0.01875 0.036162 0.9428"""),
           numbers("""0.000434 -0.000122
                      0.026606 -0.010453
                      0.03753 -0.0551
                      0.036076 -0.066
                      0.004617 -0.009148"""),
           eye(5), eye(2))
    yield ("1.10", "",
           numbers("""0.8701 0.135 0.01159 5.014e-4 -0.03722 3.484e-4 0 0.004242 0.007249
                      0.07655 0.8974 0.01272 5.504e-4 -0.04016 3.743e-4 0 0.00453 0.007499
                      -0.1272 0.3575 0.817 0.001455 -0.1028 9.87e-4 0 0.01185 0.01872
                      -0.3635 0.6339 0.07491 0.7966 -0.2735 0.002653 0 0.03172 0.04882
                      -0.96 1.6459 -0.1289 -0.005597 0.07142 0.007108 0 0.08452 0.1259
                      -0.6644 0.11296 -0.08889 -0.003854 0.08447 0.0136 0 0.1443 0.1016
                      -0.4102 0.693 -0.05471 -0.002371 0.06649 0.01249 1.063e-4 0.09997 0.06967
                      -0.1799 0.3017 -0.02393 -0.001035 0.06059 0.02216 0 0.2139 0.03554
                      -0.3451 0.5804 -0.04596 -0.001989 0.1056 0.01986 0 0.2191 0.2152"""),
           numbers("""4.76e-4 -5.701e-5 -8.368e-3
                      8.79e-5 -4.773e-4 -2.73e-4
                      1.482e-4 -1.312e-3 8.876e-4
                      3.892e-4 -3.513e-3 2.48e-3
                      1.034e-3 -9.275e-3 6.68e-3
                      7.203e-4 -6.159e-3 3.834e-3
                      4.454e-4 -3.683e-3 2.029e-3
                      1.971e-4 -1.554e-3 6.937e-4
                      3.773e-4 -3.028e-3 1.469e-3"""),
           diagonal(50.0, 0.0, 0.0, 0.0, 50.0, 0.0, 0.0, 0.0, 0.0), eye(3))
    # The paper machine: delays and filters of two loops, and the integrals of their errors.
    a = [[0.0] * 11 for _ in range(11)]
    for i in range(1, 5):
        a[i][i - 1] = 1.0
    a[5][4], a[5][5], a[6][4], a[6][6] = 0.222, 0.778, 0.4, 0.6
    a[7][7], a[7][8], a[8][7] = 1.372, -0.47, 1.0
    a[9][5], a[9][9] = -15.0, 1.0
    a[10][6], a[10][7], a[10][8], a[10][10] = -7.0, 5.357, 3.943, 1.0
    b = [[0.0, 0.0] for _ in range(11)]
    b[0][0], b[7][1] = 1.0, 0.098
    c = [[0.0] * 11 for _ in range(4)]
    c[0][5], c[1][6], c[1][7], c[1][8], c[2][9], c[3][10] = 15.0, 7.0, -5.357, -3.943, 1.0, 1.0
    yield "1.11", "", a, b, weighted(c, diagonal(0.5, 5.0, 0.5, 5.0)), diagonal(400.0, 700.0)
    # The same with a model of its disturbances.
    a = [[0.0] * 13 for _ in range(13)]
    for i in range(10):
        a[i][i + 1] = 1.0
    a[5][6] = a[7][8] = 0.0
    a[11][11] = a[12][12] = 1.0
    a[11][0], a[12][0], a[5][5], a[7][6], a[12][6] = -3.318, -1.5484, 0.7788, -0.4724, 0.3981
    a[7][7], a[12][7], a[12][8], a[10][10] = 1.3746, 0.5113, 5.7865, 0.8071
    b = [[0.0, 0.0] for _ in range(13)]
    b[5][0], b[7][1] = 1.0, 1.0
    c = [[0.0] * 13 for _ in range(4)]
    c[0][0], c[1][0], c[1][6], c[1][7], c[1][8] = 3.318, 1.5484, -0.3981, -0.5113, -5.7865
    c[2][11], c[3][12] = 1.0, 1.0
    yield "1.12", "", a, b, weighted(c, diagonal(0.5, 5.0, 0.5, 5.0)), diagonal(400.0, 700.0)
    yield power_plant()


def power_plant():
    """26 states: two chains of second-order sections with cross couplings, and the integrals of six outputs."""
    # Columns 2, 4, .. 16 of the upper part, for rows 1 to 16.
    columns = numbers("""
        -0.4607 0.0045 0.1304 0.0731 0.0608 0.0178 0.0067 -0.0090
        1.4269 0.0034 -0.1702 -0.0728 -0.0527 -0.0595 0.0011 0.0065
        0.0179 -0.1242 -0.1065 -0.0351 -0.0603 -0.0939 0.0004 0.0693
        -0.0090 1.0126 0.2113 0.0411 0.0543 0.0521 0.0013 -0.0728
        0.0406 -0.2096 -0.0777 0.0492 -0.0334 -0.0421 -0.0082 -0.1448
        -0.0431 0.1458 1.1320 -0.0392 0.0343 0.0290 0.0002 0.1535
        0.1253 0.1610 0.0953 -0.6278 -0.0066 0.0144 0.0047 0.1116
        -0.1222 -0.2340 -0.0159 1.5797 0.0551 -0.0192 -0.0004 -0.1173
        0.0086 -0.1020 -0.1038 0.0057 0.1812 -0.0301 0.0048 -0.0517
        -0.0094 0.1284 0.0851 -0.0079 0.7771 0.0253 0.0081 0.0529
        0.0095 -0.0669 -0.0342 0.0658 -0.0341 0.2095 0.0107 0.0923
        0.0237 0.0813 0.0268 -0.0848 0.0164 0.6173 -0.0138 -0.0945
        0.0189 -0.3275 -0.1496 0.0689 -0.1201 0.1359 0.3119 -0.0085
        -0.0059 0.2417 0.1944 -0.0739 0.3157 0.1776 0.3995 0.0516
        -0.0373 0.0986 -0.1332 0.0657 -0.0546 0.0440 -0.0111 -0.0391
        0.0610 -0.0931 0.1297 -0.0714 0.0254 -0.0848 0.0055 1.0233""")
    a = [[0.0] * 26 for _ in range(26)]
    for i, row in enumerate(columns):
        for k, v in enumerate(row):
            a[i][2 * k + 1] = v
        if i % 2 == 1:
            a[i][i - 1] = 1.0
    for i, (left, right) in enumerate(numbers("-0.1228 2.0351\n0.8965 3.0747\n-0.0041 0.26\n0.0042 0.1704")):
        a[16 + i][17], a[16 + i][19] = left, right
    a[17][16] = a[19][18] = 1.0
    for i, output in enumerate([2, 4, 12, 14, 16, 18]):
        a[20 + i][output - 1] = -1.0
        a[20 + i][20 + i] = 1.0
    b = numbers("""
        -0.0026 0.1205 -0.0022 -0.0603 0.0091 -0.0362
        0.0010 -0.0096 0.0038 -0.0378 0.0004 0.0019
        -0.0025 0.0800 -0.0014 -0.0647 0.0188 0.0001
        -0.0011 0.0399 0.0034 -0.0165 0.0057 0.0087
        -0.0014 0.0547 -0.0205 -0.0001 0.0070 -0.0005
        -0.0004 0.0105 0.0056 -0.0131 -0.0014 0.0023
        -0.0086 0.0656 0.0191 -0.0307 -0.0617 0.0095
        -0.0101 0.2088 -0.0095 -0.0300 0.0038 0.0086
        -0.0033 -0.0021 -0.0294 -0.0086 0.0035 -0.0007
        0.0013 0.0050 0.0187 -0.0022 -0.0013 0.0002
        0.0081 0.0446 -0.0092 0.0964 0.0258 -0.0081
        0.0244 0.1400 0.0039 -0.5574 -0.0419 0.0152
        0.0147 -0.1752 -0.0013 -1.2201 -0.0057 -0.0014
        0.0103 0.2547 0.0006 1.9353 -0.0402 0.0117
        0.0008 0.1287 0.0077 -0.1102 0.0106 0.0075
        0.0006 0.0210 0.0002 0.0126 0.0066 0.0004
        0 0.0901 -0.0152 0 -0.2026 0
        0 0.0810 0.0026 0 -0.0255 0
        0 0.0544 0.0011 0 -0.0037 0
        0 -0.0668 -0.0035 0 0.0039 0""") + [[0.0] * 6 for _ in range(6)]
    q = diagonal(*[0.0] * 20, 2.0, 1.0, 3.0, 3.0, 4.0, 1.0)
    return "1.13", "", a, b, q, diagonal(0.1, 0.1, 10.0, 0.1, 10.0, 1.0)


def with_parameters():
    for r in (1e-8, 1.0, 1e6, 1e8):
        yield "2.1", f"r = {r:g}", [[4.0, 3.0], [-4.5, -3.5]], [[1.0], [-1.0]], [[9.0, 6.0], [6.0, 4.0]], [[r]]
    for e in (100.0, 1e6, 1e8):
        yield ("2.2", f"epsilon = {e:g}", diagonal(0.9512, 0.9048), [[4.877, 4.877], [-1.1895, 3.569]],
               diagonal(0.005, 0.02), diagonal(1.0 / (3.0 * e), 3.0 * e))
    for e in (1.0, 1e6, 1e8):
        yield "2.3", f"epsilon = {e:g}", [[0.0, e], [0.0, 0.0]], [[0.0], [1.0]], eye(2), eye(1)
    third = mp.mpf(1) / 3
    v = mp.eye(3) - 2 * third * mp.ones(3)
    a = v * mp.diag([0, 1, 3]) * v
    a = [[float(a[i, j]) for j in range(3)] for i in range(3)]
    for e in (1e-8, 1.0, 1e6, 1e8):
        yield "2.4", f"epsilon = {e:g}", a, eye(3), diagonal(e, e, e), diagonal(e, e, e)
    for tau in (100.0, 1e6, 1e8):
        d, k = 1.0, 1.0
        a = [[1.0 - d / tau, 0.0, 0.0, 0.0]] + [[float(j == i) for j in range(4)] for i in range(3)]
        yield "2.5", f"tau = {tau:g}", a, [[k * d / tau], [0.0], [0.0], [0.0]], diagonal(0.0, 0.0, 0.0, 1.0), [[0.25]]
    for n in (10, 100):
        yield "4.1", f"n = {n}", shift(n), [[float(i == n - 1)] for i in range(n)], eye(n), eye(1)


def doubling(a, b, q, r):
    """The stabilising solution of X = Q + A'XA - A'XB (R + B'XB)^-1 B'XA, and its residual."""
    n = a.rows
    one = mp.eye(n)
    f, g, h = a.copy(), b * (r ** -1) * b.T, q.copy()
    for _ in range(80):
        w = (one + g * h) ** -1
        step = f.T * h * w * f
        f, g = f * w * f, g + f * w * g * f.T
        h = h + step
        h = (h + h.T) / 2
        if mp.norm(step, mp.inf) <= mp.mpf(10) ** -90 * mp.norm(h, mp.inf):
            break
    gain = -((r + b.T * h * b) ** -1) * (b.T * h * a)
    residual = q + a.T * h * (a + b * gain) - h
    return h, gain, mp.norm(residual, mp.inf) / mp.norm(h, mp.inf)


def radius(m):
    logarithm, weight = mp.mpf(0), mp.mpf(1)
    for _ in range(70):
        size = mp.norm(m, mp.inf)
        if size == 0:
            return mp.mpf(0)
        logarithm += weight * mp.log(size)
        weight /= 2
        m = m / size
        m = m * m
    return mp.exp(logarithm)


def closed_form(number, parameter, n):
    """X[0, 0] and X[n - 1, n - 1] as the collection gives them, for the parameters as numbers, not as doubles."""
    value = mp.mpf(parameter.split("= ")[1]) if parameter else None
    if number == "1.3":
        return mp.mpf(1), 2 + mp.sqrt(5)
    if number == "2.1":
        factor = (1 + mp.sqrt(1 + 4 * value)) / 2
        return 9 * factor, 4 * factor
    if number == "2.3":
        return mp.mpf(1), 1 + value**2
    if number == "2.4":
        v = mp.eye(3) - 2 * mp.ones(3) / 3
        x = value * v * mp.diag([1, (1 + mp.sqrt(5)) / 2, (9 + mp.sqrt(85)) / 2]) * v
        return x[0, 0], x[2, 2]
    if number == "2.5":
        r, alpha, beta = mp.mpf("0.25"), 1 - 1 / value, 1 / value
        half = r * (alpha**2 - 1) + beta**2
        return (half + mp.sqrt(half**2 + 4 * beta**2 * r)) / (2 * beta**2), mp.mpf(1)
    return None


def main():
    cases = []
    for number, parameter, a, b, q, r in [*fixed(), *with_parameters()]:
        n = len(a)
        if number == "4.1":
            # X = diag(1, .., n); nothing the input could do reaches the state in time.
            x, gain, residual, rate = mp.diag(list(range(1, n + 1))), mp.zeros(1, n), 0, 0
        else:
            x, gain, residual = doubling(*(mp.matrix(m) for m in (a, b, q, r)))
            rate = radius(mp.matrix(a) + mp.matrix(b) * gain) ** 2
        if residual > mp.mpf(10) ** -60:
            raise SystemExit(f"{number} {parameter}: residual {mp.nstr(residual, 3)}")
        print(number, parameter, mp.nstr(residual, 3), mp.nstr(rate, 12), mp.nstr(x[0, 0], 20))
        known = closed_form(number, parameter, n)
        if known and max(abs(x[0, 0] / known[0] - 1), abs(x[n - 1, n - 1] / known[1] - 1)) > mp.mpf("1e-8"):
            raise SystemExit(f"{number} {parameter}: not the known solution")
        rows = lambda m: [[float(m[i, j]) for j in range(m.cols)] for i in range(m.rows)]
        cases.append({
            "example": number, "parameter": parameter, "a": a, "b": b, "q": q, "r": r,
            "lx": rows(gain), "mean_square_rate": float(rate), "control_cost": float(sum(x[i, i] for i in range(n))),
        })
    short = lambda v: [short(w) for w in v] if isinstance(v, list) else int(v) if isinstance(v, float) and v == int(v) and abs(v) < 1e6 else v
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "riccati_benchmark.json"), "w") as out:
        out.write("[\n" + ",\n".join(json.dumps({k: short(v) for k, v in c.items()}, separators=(",", ":")) for c in cases) + "\n]\n")


if __name__ == "__main__":
    main()
