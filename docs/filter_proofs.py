#!/usr/bin/python3
"""Proves the closed forms of docs/filter.md, with its letters, under its headings.

A matrix or vector is a letter that does not commute, so that what is proved of it holds for any
size. What holds to first order only is expanded to that order, and what is left must vanish.

usage: filter_proofs.py
Prints what it proves, a line each. Where a form is wrong it prints what is left of the difference,
and the exit status is 1.
"""

import sys

import sympy as sp

# The transpose of each letter; one that is not here is its own.
TRANSPOSE = {}


def symmetric(names):
    """Letters for symmetric matrices."""
    return sp.symbols(names, commutative=False)


def matrix(name):
    """A letter for a matrix or a column, and one for its transpose."""
    pair = sp.symbols(f"{name} {name}^T", commutative=False)
    TRANSPOSE[pair[0]], TRANSPOSE[pair[1]] = pair[1], pair[0]
    return pair


def words(expression):
    """The coefficient of each product of letters."""
    result = {}
    for term in sp.Add.make_args(sp.expand(expression)):
        numbers, letters = term.args_cnc()
        word = sp.Mul(*letters)
        result[word] = result.get(word, 0) + sp.Mul(*numbers)
    return result


def transposed(expression):
    def turned(factor):
        base, exponent = factor.as_base_exp()
        return TRANSPOSE.get(base, base) ** exponent

    result = 0
    for word, number in words(expression).items():
        result += number * sp.Mul(*[turned(f) for f in reversed(word.args_cnc()[1])])
    return result


def replaced(expression, product, value):
    """`product` of letters written as `value`, everywhere."""
    before = None
    while before != expression:
        before, expression = expression, sp.expand(sp.expand(expression).subs(product, value))
    return expression


def first_order(expression, small):
    """Without the products of two letters of `small` and more."""
    result = 0
    for word, number in words(expression).items():
        powers = [f.as_base_exp() for f in word.args_cnc()[1]]
        if sum(exponent for base, exponent in powers if base in small) < 2:
            result += number * word
    return result


def left(difference):
    """What is left of a difference, of matrices or of expressions in letters: 0 when it is zero."""
    if isinstance(difference, sp.MatrixBase):
        entries = difference.applyfunc(left)
        return sp.S.Zero if entries.is_zero_matrix else entries

    def simple(number):
        if not number.is_rational_function():
            return sp.simplify(number)
        return number if sp.expand(sp.numer(sp.together(number))) else sp.S.Zero

    return sum((simple(number) * word for word, number in words(difference).items()), sp.S.Zero)


# Section 1

def step():
    a, b, h, d, coupling, e, theta, phi = sp.symbols("a b h d K2 e theta phi", real=True)
    g1, g2, m1, m2, ks, w = sp.symbols("gamma1 gamma2 mu1 mu2 ks w", real=True)
    xr, xi, yr, yi = sp.symbols("xr xi yr yi", real=True)
    c, s = sp.cos(2 * theta), sp.sin(2 * theta)
    gamma, mu = g1 * c + g2 * s, m2 * c - m1 * s
    fx, fy = xr + sp.I * xi, yr + sp.I * yi
    lag = sp.cos(phi) - sp.I * sp.sin(phi)
    ef1 = sp.expand(lag * (sp.cos(theta) * fx + sp.sin(theta) * fy))
    ef2 = sp.expand(lag * (sp.cos(theta) * fy - sp.sin(theta) * fx))
    f = sp.Matrix([sp.im(ef1), sp.re(ef2)]) / (2 * w)

    r, p = sp.Matrix([a, b]), sp.Matrix([g1, g2, m1, m2, ks])
    # (C) and (D) with e, as section 8 of docs/derivation.md has them.
    rate = sp.Matrix([
        -d * (a + e * b) * (1 + gamma) + coupling * mu * (b - e * a),
        -d * (b + e * a) * (1 - gamma) - coupling * mu * (a - e * b)]) + ks * f
    m = sp.Matrix([[-d * (1 + gamma) - e * coupling * mu, coupling * mu - e * d * (1 + gamma)],
                   [-coupling * mu - e * d * (1 - gamma), e * coupling * mu - d * (1 - gamma)]])
    yield "M r + ks f is the right side of (C) and (D)", m * r + ks * f - rate

    def by_parameters(at):
        by_gamma = sp.Matrix([-d * (at[0] + e * at[1]), d * (at[1] + e * at[0])])
        by_mu = sp.Matrix([coupling * (at[1] - e * at[0]), -coupling * (at[0] - e * at[1])])
        return sp.Matrix.hstack(c * by_gamma, s * by_gamma, -s * by_mu, c * by_mu, f)

    yield "the columns B from what gamma does along and mu across", (
        by_parameters(r) - rate.jacobian(p))

    # With M and B as they are, but for this proof in letters of their own.
    middle = r + h / 2 * (m * r + ks * f)
    after = r + h * (m * middle + ks * f)
    one = sp.eye(2)
    half = one + h / 2 * m
    transition = one + h * m * half
    yield "r+ = T r + ks g", after - (transition * r + ks * h * half * f)
    yield "r+ = r + h (1 + h/2 M) (M r + ks f): an r at rest stays", (
        after - (r + h * half * (m * r + ks * f)))
    yield "T is the derivative of the step by r", transition - after.jacobian(r)
    yield "G is the derivative of the step by p", (
        h * (by_parameters(middle) + h / 2 * m * by_parameters(r)) - after.jacobian(p))

    gamma_slope, mu_slope = 2 * (g2 * c - g1 * s), -2 * (m1 * c + m2 * s)
    turned = ks * sp.Matrix([sp.im(ef2), -sp.re(ef1)]) / (2 * w)
    by_theta = turned + gamma_slope * sp.Matrix([-d * (a + e * b), d * (b + e * a)]) + (
        mu_slope * coupling * sp.Matrix([b - e * a, -(a - e * b)]))
    slopes = sp.Matrix.hstack(by_theta, sp.Matrix([turned[1], turned[0]]))
    yield "the slopes by theta and phi", slopes - rate.jacobian(sp.Matrix([theta, phi]))


# Section 2

def split():
    (c, ct), (t, tt), (g, gt) = matrix("C"), matrix("T"), matrix("G")
    s, p, n = symmetric("S P N")
    axes, cross = c * p * ct + s, c * p
    # A P7 A^T + Q, with A = [[T, G], [0, 1]] and Q = [[N, 0], [0, 0]].
    full_cross = t * cross + g * p
    full_axes = t * axes * tt + t * cross * gt + g * transposed(cross) * tt + g * p * gt + n
    after, rest = t * c + g, t * s * tt + n
    yield "the covariance of r and p after a step", after * p - full_cross
    yield "the covariance of r after a step", after * p * transposed(after) + rest - full_axes


# Section 3

def measurement():
    (c, ct) = matrix("C")
    p, r, w, x = symmetric("P R W X")  # W = S + R, X = C P C^T + W
    s = w - r

    def zero(expression):
        return replaced(expression, c * p * ct, x - w)

    # (3): the gain of all seven is [C P C^T + S; P C^T] X^-1.
    full_axes, full_parameters = (x - r) * x**-1, p * ct * x**-1
    k = s * w**-1
    after = (1 - k) * c
    p_after = p - full_parameters * c * p
    yield "the gain of r: K + C+ (gain of p)", zero(k + after * full_parameters - full_axes)
    yield "the covariance of r and p", zero(after * p_after - (1 - full_axes) * c * p)
    yield "the covariance of r", zero(
        after * p_after * transposed(after) + (1 - k) * s - (1 - full_axes) * (x - r))
    yield "1 - K = R (S + R)^-1", sp.expand(1 - k - r * w**-1)


def mean_of_interval():
    (ce, cet), (cm, cmt), (te, tet), (tm, tmt) = (matrix(n) for n in ("Ce", "Cm", "Te", "Tm"))
    (n_em, n_me) = matrix("Nem")
    s, p, n_e, m, w, x = symmetric("S P Ne V W X")  # W = Tm S Tm^T + V, X = Cm P Cm^T + W

    def zero(expression):
        return replaced(replaced(expression, cm * p * cmt, x - w), tm * s * tmt, w - m)

    s_em = te * s * tmt + n_em
    s_e = te * s * tet + n_e
    k = s_em * w**-1
    after = ce - k * cm
    # What any linear estimate gains: covariance with the measurement times X^-1.
    full = (ce * p * cmt + s_em) * x**-1
    full_parameters = p * cmt * x**-1
    p_after = p - full_parameters * cm * p
    s_after = s_e - k * transposed(s_em)
    yield "the gain of r: K + C+ (gain of p)", zero(k + after * full_parameters - full)
    yield "the covariance of r and p", zero(
        after * p_after - (ce * p - full * cm * p))
    yield "the covariance of r", zero(
        after * p_after * transposed(after) + s_after
        - (ce * p * cet + s_e - full * x * transposed(full)))
    rest = te - k * tm
    joseph = rest * s * transposed(rest) + n_e - k * n_me - n_em * transposed(k) + (
        k * m * transposed(k))
    yield "Joseph's form of S+", zero(joseph - s_after)

    # One step, whose end is all that is measured: Tm = Te and all process noises are N.
    sample = symmetric("R")
    one_step = joseph.subs({tm: te, tmt: tet, n_em: n_e, n_me: n_e, m: n_e + sample})
    known = w - sample
    one_step = replaced(one_step, te * s * tet, known - n_e)
    yield "with one sample the mean is the step of above", sp.expand(
        one_step - (1 - known * w**-1) * known)


# Section 4

def gathered(noise, eps, count):
    """The noises of end, end with sum and sum after `count` steps more."""
    end, end_sum, total, each = noise
    n = count
    t = 1 + n * eps
    to_sum = (n + 1) / 2 * t + (n - 1) / 2
    moved = eps * each
    pairs = n * (n + 1) / 2
    triples = n * (n + 1) * (2 * n + 1) / 6
    through = n * (n - 1) * (3 * n * (n - 1) + 4 * (2 * n - 1) + 6) / 24
    sum_sum = to_sum * end_sum
    return (
        t * end * transposed(t)
        + n * each + n * (n - 1) / 2 * (moved + transposed(moved)),
        t * (end_sum + end * transposed(to_sum))
        + pairs * (each + (n - 1) * (2 * moved + transposed(moved)) / 3),
        total + sum_sum + transposed(sum_sum) + to_sum * end * transposed(to_sum)
        + triples * each + through * (moved + transposed(moved)),
        each)


def noise_over_steps():
    n, m, j, q = sp.symbols("n m j q", integer=True, positive=True)
    pairs, triples = n * (n + 1) / 2, n * (n + 1) * (2 * n + 1) / 6
    through = n * (n - 1) * (3 * n * (n - 1) + 4 * (2 * n - 1) + 6) / 24

    def summed(expression):
        return sp.summation(expression, (q, 1, n))

    yield "pairs: the sum of q", summed(q) - pairs
    yield "triples: the sum of q^2", summed(q**2) - triples
    yield "through: the sum of q^2 (q - 1) / 2", summed(q**2 * (q - 1) / 2) - through
    yield "end: the sum of q - 1", summed(q - 1) - n * (n - 1) / 2
    yield "end with sum: the sums of q (q - 1) and of q (q - 1) / 2", sp.Matrix([
        summed(q * (q - 1)) - pairs * sp.Rational(2, 3) * (n - 1),
        summed(q * (q - 1) / 2) - pairs * sp.Rational(1, 3) * (n - 1)])

    (eps, eps_t), (es, _) = matrix("eps"), matrix("Nes")
    e, s, each = symmetric("Ne Ns N")
    small = (eps, eps_t)
    before = (e, es, s, each)
    # By the definition: the noise of one step, and the sum that takes the new end in.
    t = 1 + eps
    end = t * e * transposed(t) + each
    end_sum = t * es + end
    by_one = (end, end_sum, s + t * es + transposed(t * es) + end, each)
    for name, one, other in zip(("end", "end with sum", "sum"), gathered(before, eps, sp.S.One),
                                by_one):
        yield f"noise of one step: {name}", sp.expand(one - other)
    # With that, for any count: n steps at once and m more at once are n + m at once.
    in_two = gathered(gathered(before, eps, n), eps, m)
    at_once = gathered(before, eps, n + m)
    for name, one, other in zip(("end", "end with sum", "sum"), in_two, at_once):
        yield f"noise of n steps and then m: {name}, to first order in T - 1", first_order(
            one - other, small)

    # What the start and the parameters pass on to the sum, to second order.
    x = sp.symbols("x")  # T = 1 + x for one number; each step is (1 + x)^(1/n)
    power = sp.series((1 + x) ** (j / n), x, 0, 3).removeO()
    to_sum = sp.expand(sp.summation(sp.expand(power), (j, 1, n)))
    yield "T_s = (n + 1)/2 T + (n - 1)/2, too large by (T - 1)^2 (n^2 - 1) / (12 n)", sp.expand(
        (n + 1) * (1 + x) / 2 + (n - 1) / 2 - x**2 * (n**2 - 1) / (12 * n) - to_sum)
    # Each step adds y and hands on 1 + z of what there is.
    y, z = sp.symbols("y z")
    after = y * (j + z * j * (j - 1) / 2)
    yield "after j steps y (j + z j (j - 1) / 2), to first order in z", sp.expand(
        (1 + z) * after + y - after.subs(j, j + 1)).coeff(z, 0) + sp.expand(
            (1 + z) * after + y - after.subs(j, j + 1)).coeff(z, 1)
    whole = sp.expand(sp.summation(after, (j, 1, n)))
    yield "G_s = (n + 1)/2 G, too large by z y n (n^2 - 1) / 12", sp.expand(
        (n + 1) / 2 * after.subs(j, n) - z * y * n * (n**2 - 1) / 12 - whole)


def noise_of_angles():
    ks = sp.symbols("ks")
    along, across = sp.symbols("along across")  # Re(E F1) / 2w, Im(E F2) / 2w of a step
    u1, u2, v1, v2 = sp.symbols("u1 u2 v1 v2")  # what gamma and mu add to the slopes

    def outers(along_part, across_part):
        by_theta = sp.Matrix([u1 + ks * across_part, u2 - ks * along_part])
        by_phi = sp.Matrix([v1 - ks * along_part, v2 + ks * across_part])
        return by_theta * by_theta.T + by_phi * by_phi.T

    def mean(expression):
        """Over steps of any number: products of what differs from step to step have letters."""
        polynomial = sp.Poly(sp.expand(expression), along, across)
        return sum(number * sp.Symbol(f"mean_{i}_{j}") if i + j else number
                   for (i, j), number in polynomial.terms())

    mean_along, mean_across = mean(along), mean(across)
    squares = mean(along**2 + across**2) - (mean_along**2 + mean_across**2)
    product = mean(along * across) - mean_along * mean_across
    spread = ks**2 * sp.Matrix([[squares, -2 * product], [-2 * product, squares]])
    yield "the mean of the squared slopes: the square of their mean, and the spread", (
        outers(along, across).applyfunc(mean) - outers(mean_along, mean_across) - spread)


# Section 5

def one_row():
    (u, ut), (k, kt) = matrix("u"), matrix("k")  # column j of U; k before it
    d, v, alpha = sp.symbols("d v alpha", positive=True)  # d_j, v_j, alpha before it
    (row, row_t) = matrix("l")
    next_alpha = alpha + d * v**2
    next_k = k + d * v * u
    next_d = d * alpha / next_alpha
    next_u = u - v / alpha * k
    yield "a column: d+ u+ u+^T - d u u^T is the change of - k k^T / alpha", left(
        next_d * next_u * transposed(next_u) - d * u * ut
        + next_k * transposed(next_k) / next_alpha - k * kt / alpha)
    # In the end k = P l and alpha = l^T P l + R.
    p, = symmetric("P,")
    gain = p * row / alpha
    rest = 1 - gain * row_t
    r = sp.symbols("R", positive=True)
    joseph = sp.expand(rest * p * transposed(rest) + r * gain * transposed(gain))
    joseph = replaced(joseph, row_t * p * row, alpha - r)
    yield "P - k k^T / alpha is (3)", left(joseph - (p - p * row * row_t * p / alpha))


def two_rows():
    # k1 = P l1, k2 = P l2 of the rows as they came, and what the rows make of them.
    (k1, k1t), (k2, k2t) = matrix("k1"), matrix("k2")
    a11, a12, a22, r11, r12, r22, nu1, nu2 = sp.symbols("A11 A12 A22 R11 R12 R22 nu1 nu2")
    plain = sp.Matrix([[a11 + r11, a12 + r12], [a12 + r12, a22 + r22]])
    inverse = plain.adjugate() / plain.det()

    shared = r12 / r11
    alpha1 = a11 + r11
    common = a12 - shared * a11  # l1^T P (l2 - shared l1)
    noise2 = r22 - shared * r12
    # The second row, less its share in the first, after the first.
    second = k2 - shared * k1 - common / alpha1 * k1
    alpha2 = a22 - 2 * shared * a12 + shared**2 * a11 - common**2 / alpha1 + noise2
    innovation2 = nu2 - shared * nu1 - common * nu1 / alpha1
    share1, share2 = nu1 / alpha1, innovation2 / alpha2
    nu = sp.Matrix([nu1, nu2])
    weights = inverse * nu
    yield "what p gains", left(
        share1 * k1 + share2 * second - (weights[0] * k1 + weights[1] * k2))
    gain = [inverse[0, j] * k1 + inverse[1, j] * k2 for j in range(2)]
    yield "P+", left(
        k1 * k1t / alpha1 + second * transposed(second) / alpha2 - (gain[0] * k1t + gain[1] * k2t))
    cross = shared * alpha1 + common
    yield "the covariance of the innovation", sp.Matrix([[alpha1, cross], [
        cross, alpha2 + cross**2 / alpha1]]) - plain
    yield "the normalised innovation squared", left(
        nu1 * share1 + innovation2 * share2 - (nu.T * inverse * nu)[0])


def two_rows_as_written():
    """The whole recursion, for two parameters, against (3)."""
    names = "d0 d1 u01 l10 l11 l20 l21 R11 R12 R22 nu1 nu2".split()
    # A field of fractions: each number is in lowest terms, so equal numbers are the same.
    field, d0, d1, u01, l10, l11, l20, l21, r11, r12, r22, nu1, nu2 = sp.field(names, sp.QQ)
    one, zero, places = field.one, field.zero, range(2)
    diagonal, upper, rows = [d0, d1], [[one, u01], [zero, one]], [[l10, l11], [l20, l21]]

    def measured(diagonal, upper, row, noise):
        """One row: the new factors, k = P l and the variance of the innovation."""
        v = [sum((row[i] * upper[i][j] for i in places), zero) for j in places]
        alpha, k = noise, [zero, zero]
        new_diagonal, new_upper = [zero, zero], [[zero, zero], [zero, zero]]
        for j in places:
            next_alpha = alpha + diagonal[j] * v[j] ** 2
            for i in places:
                new_upper[i][j] = upper[i][j] - v[j] / alpha * k[i]
            k = [k[i] + diagonal[j] * v[j] * upper[i][j] for i in places]
            new_diagonal[j], alpha = diagonal[j] * alpha / next_alpha, next_alpha
        return new_diagonal, new_upper, k, alpha

    shared = r12 / r11
    second = [rows[1][i] - shared * rows[0][i] for i in places]
    between_diagonal, between_upper, k1, alpha1 = measured(diagonal, upper, rows[0], r11)
    new_diagonal, new_upper, k2, alpha2 = measured(between_diagonal, between_upper, second,
                                                   r22 - shared * r12)
    m = shared + sum((second[i] * k1[i] for i in places), zero) / alpha1
    share1, share2 = nu1 / alpha1, (nu2 - m * nu1) / alpha2

    def number(of):
        return sp.Matrix(2, len(of[0]), [entry.as_expr() for row in of for entry in row])

    def covariance(factors, weights):
        return [[sum((factors[i][k] * weights[k] * factors[j][k] for k in places), zero)
                 for j in places] for i in places]

    before, after = covariance(upper, diagonal), covariance(new_upper, new_diagonal)
    k = [[sum((before[i][j] * row[j] for j in places), zero) for i in places] for row in rows]
    a = [[sum((rows[m][i] * k[n][i] for i in places), zero) for n in (0, 1)] for m in (0, 1)]
    x11, x12, x22 = a[0][0] + r11, a[0][1] + r12, a[1][1] + r22
    det = x11 * x22 - x12 * x12
    gain = [[(k[0][i] * x22 - k[1][i] * x12) / det, (k[1][i] * x11 - k[0][i] * x12) / det]
            for i in places]
    yield "as written: P+", number(
        [[before[i][j] - gain[i][0] * k[0][j] - gain[i][1] * k[1][j] - after[i][j]
          for j in places] for i in places])
    yield "as written: what p gains", number(
        [[share1 * k1[i] + share2 * k2[i] - gain[i][0] * nu1 - gain[i][1] * nu2] for i in places])
    yield "as written: U+ is unit upper triangular", number(
        [[new_upper[0][0] - one, zero], [new_upper[1][0], new_upper[1][1] - one]])


def addition():
    (u, ut), (b, bt) = matrix("u"), matrix("b")  # column j of U; what is left of a below it
    d, c, top = sp.symbols("d c top", positive=True)  # d_j, the weight, entry j of a
    a = b + top * u
    next_d = d + c * top**2
    next_u = u + c * top / next_d * b
    yield "a column: d u u^T + c a a^T = d+ u+ u+^T + c+ b b^T", left(
        d * u * ut + c * a * transposed(a) - next_d * next_u * transposed(next_u)
        - c * d / next_d * b * bt)

    # As written, for r of one number and p of two: r stands above p, with the row C U.
    d0, d1, u01, c0, c1, s, a0, a1 = sp.symbols("d0 d1 u01 c0 c1 S a0 a1")
    regression = sp.Matrix([[c0, c1]])
    u_matrix = sp.Matrix([[1, u01], [0, 1]])
    weight = c
    direction, row = sp.Matrix([a0, a1]), regression * u_matrix
    diagonal, upper, shape = [d0, d1], u_matrix.copy(), sp.Matrix([a0, a1])
    row_shape = sp.S.Zero
    for j in (1, 0):
        before = diagonal[j]
        diagonal[j] = before + weight * shape[j] ** 2
        share = weight * shape[j] / diagonal[j]
        for i in range(j):
            shape[i] -= shape[j] * upper[i, j]
            upper[i, j] += share * shape[i]
        row_shape -= shape[j] * row[j]
        row[j] += share * row_shape
        weight = weight * before / diagonal[j]
    after = row * upper.inv()
    p = u_matrix * sp.diag(d0, d1) * u_matrix.T
    p_after = upper * sp.diag(*diagonal) * upper.T
    s_after = s + weight * row_shape**2
    yield "as written: P + c a a^T", (p_after - p - c * direction * direction.T).applyfunc(
        sp.simplify)
    yield "as written: the covariance of r and p stays", (
        after * p_after - regression * p).applyfunc(sp.simplify)
    yield "as written: the covariance of r stays", (
        after * p_after * after.T - regression * p * regression.T).applyfunc(sp.simplify) + (
            sp.Matrix([[sp.simplify(s_after - s)]]))


def forgetting():
    (l, lt), (q, qt), (k, kt) = matrix("l"), matrix("q"), matrix("k")
    p, = symmetric("P,")
    growth, variance, other, cov = sp.symbols("g v v_q v_lq", positive=True)

    def numbers(expression):
        for product, value in ((lt * p * l, variance), (qt * p * q, other), (lt * p * q, cov),
                               (qt * p * l, cov)):
            expression = replaced(expression, product, value)
        return expression

    added = (growth - 1) / variance * p * l * lt * p
    after = p + added
    yield "the variance along l grows by the factor", numbers(lt * after * l) - growth * variance
    yield "what is not correlated with l^T p keeps its variance", numbers(
        qt * after * q).subs(cov, 0) - other
    # P l = k, so l = P^-1 k.
    in_k = p + (growth - 1) / variance * k * kt
    information = p**-1 - (1 - 1 / growth) / variance * p**-1 * k * kt * p**-1
    product = replaced(sp.expand(in_k * information), kt * p**-1 * k, variance)
    yield "of the information only that of l^T p is taken: P+^-1", left(product - 1)
    # Then the same with another row.
    rho2 = sp.symbols("rho^2", positive=True)
    cov_after, other_after = numbers(lt * after * q), numbers(qt * after * q)
    both = growth * variance + (growth - 1) / other_after * cov_after**2
    expected = growth * variance * (1 + (growth - 1) * growth * rho2 / (1 + (growth - 1) * rho2))
    yield "and with a second row correlated by rho", sp.simplify(
        both - expected.subs(rho2, cov**2 / (variance * other)))


# Section 6

def two_drives():
    x, z, q, eps = sp.symbols("x z q epsilon", real=True)

    def average(expression, order):
        """Over the step with weights e^(-z (1 - x)), z = eps z, up to eps^order."""
        weight = sp.exp(-eps * z * (1 - x))

        def integral(f, low, high):
            f = sp.expand(sp.series(f, eps, 0, order + 1).removeO())
            return sp.integrate(f, (x, low, high))

        above = integral(weight * expression[0], 0, q) + integral(weight * expression[1], q, 1)
        below = integral(weight, 0, 1)
        return sp.expand(sp.series(above / below, eps, 0, order + 1).removeO())

    yield "the middle: 1/2 + z/12 - z^3/720", average((x, x), 3) - (
        sp.Rational(1, 2) + eps * z / 12 - eps**3 * z**3 / 720)
    moment = q * (1 - q) / 2
    yield "the share of the first drive: q - z q (1 - q) / 2", average((1, 0), 1) - (
        q - moment * eps * z)
    yield "the moment of a unit step about the middle: q (1 - q) / 2", sp.expand(
        sp.integrate(x - sp.Rational(1, 2), (x, q, 1)) - moment)
    angle = sp.symbols("Delta")
    yield "a constant drive under a turning pattern: 1 - Delta^2 / 24", sp.series(
        sp.integrate(sp.cos(angle * x), (x, -sp.Rational(1, 2), sp.Rational(1, 2))), angle, 0,
        4).removeO() - (1 - angle**2 / 24)

    # All at once. X + i Y turns by e^(-i (phi + theta)), X - i Y by e^(-i (phi - theta)).
    theta, phi, before, change = sp.symbols("theta phi F DF")
    middle = sp.Rational(1, 2) + eps * z / 12
    first = q - moment * eps * z
    for name, sign in (("X + i Y", 1), ("X - i Y", -1)):
        turn = -sp.I * eps * (phi + sign * theta)
        exact = average([sp.exp(turn * (x - middle)) * drive
                         for drive in (before, before + eps * change)], 2)
        mean = first * before + (1 - first) * (before + eps * change)
        taken = (1 - (eps * theta) ** 2 / 24) * mean + turn * moment * eps * change
        left_out = -eps**2 * (phi**2 + 2 * sign * theta * phi) / 24 * before
        difference = sp.expand(exact - taken - left_out)
        yield (f"both drives in one step, to second order: {name}",
               sum(difference.coeff(eps, k) for k in range(3)))

    # The terms with which the pattern turns on, for the drive as it is, X and Y.
    xr, xi, yr, yi, t, f = sp.symbols("xr xi yr yi t f", real=True)
    fx, fy = xr + sp.I * xi, yr + sp.I * yi
    turned = sp.Matrix([[sp.cos(t), sp.sin(t)], [-sp.sin(t), sp.cos(t)]]) * sp.Matrix([fx, fy])
    by_turning = (sp.exp(-sp.I * f) * turned).jacobian(sp.Matrix([t, f])).subs({t: 0, f: 0})
    yield "turning theta takes F to (Fy, -Fx), turning phi to -i F", by_turning - sp.Matrix(
        [[fy, -sp.I * fx], [-fx, -sp.I * fy]])
    yield "the midpoint step answers a constant drive to z^2 / 6", sp.series(
        (1 - sp.exp(-z)) / z, z, 0, 3).removeO() - ((1 - z / 2) + z**2 / 6)


def drive_step():
    w, t, tau, psi, ks, sr, si = sp.symbols("w t tau psi k_s Sr Si", positive=True)
    step_ = sr + sp.I * si
    # x'' + w^2 x = ks Re[S e^{i (w t + psi)}] from rest, exactly.
    drive = sr * sp.cos(w * tau + psi) - si * sp.sin(w * tau + psi)
    exact = ks * sp.integrate(sp.expand(sp.expand_trig(sp.sin(w * (t - tau)) / w * drive)),
                              (tau, 0, t))
    jump = ks / (4 * w**2) * (step_ - sp.conjugate(step_) * sp.exp(-2 * sp.I * psi))
    envelope = -sp.I * ks / (2 * w) * step_ * t + jump
    motion = sp.re(sp.expand_complex(envelope * sp.exp(sp.I * (w * t + psi))))
    yield "the envelope after a step of the drive, its slope and its jump", sp.simplify(
        sp.expand_trig(sp.expand(motion - exact)))
    h = sp.symbols("h", positive=True)
    share = step_ / (2 * w * h)
    mean = sp.I * (share - sp.conjugate(share) * sp.exp(-2 * sp.I * psi))
    yield "the jump as a drive held for h: i (s - s* e^{-2 i psi}), s = S / 2 w h", sp.simplify(
        -sp.I * ks / (2 * w) * h * mean - jump)


# Section 7

def linear_enough():
    g, m, e = sp.symbols("g m e", real=True)  # d times the error of gamma, K2 times that of mu
    error = sp.Matrix([[-g - e * m, m - e * g], [-m + e * g, g + e * m]])
    one, two = g + e * m, m - e * g
    yield "the error of M stretches by |g + e m| + |m - e g| at most", sp.Matrix(
        [(error.T * error - (one + sign * two) ** 2 * sp.eye(2)).det() for sign in (1, -1)])
    t, h, start, rate, norm = sp.symbols("t h r0 v n", positive=True)
    at = sp.integrate(norm * (start + rate * t), t)
    yield "what is neglected at the end: n h (r0 + v h / 2)", at.subs(t, h) - (
        norm * h * (start + rate * h / 2))
    yield "and in the mean: n h (r0 / 2 + v h / 6)", sp.integrate(at, (t, 0, h)) / h - (
        norm * h * (start / 2 + rate * h / 6))
    # The normalised innovation squared of an innovation nu + b.
    n1, n2, b1, b2 = sp.symbols("nu1 nu2 b1 b2", real=True)
    x11, x12, x22 = sp.symbols("X11 X12 X22")
    x = sp.Matrix([[x11, x12], [x12, x22]])
    nu, b = sp.Matrix([n1, n2]), sp.Matrix([b1, b2])
    square = sp.Poly(((nu + b).T * x.inv() * (nu + b))[0], n1, n2)
    moments = {(0, 0): 1, (2, 0): x11, (1, 1): x12, (0, 2): x22}
    mean = sum(number * moments.get(power, 0) for power, number in square.terms())
    yield "a bias b adds b^T X^-1 b to the mean of the NIS", sp.simplify(
        mean - 2 - (b.T * x.inv() * b)[0])


SECTIONS = [
    ("1. One step", (step,)),
    ("2. The split", (split,)),
    ("3. A measurement", (measurement, mean_of_interval)),
    ("4. Noise over n steps", (noise_over_steps, noise_of_angles)),
    ("5. The factored measurement",
     (one_row, two_rows, two_rows_as_written, addition, forgetting)),
    ("6. Two drives in one step", (two_drives, drive_step)),
    ("7. Linear enough", (linear_enough,)),
]


def main() -> int:
    proved = wrong = 0
    for section, functions in SECTIONS:
        print(section)
        for function in functions:
            for what, difference in function():
                rest = left(difference)
                if rest == 0:
                    proved += 1
                    print(f"  {function.__name__}: {what}")
                else:
                    wrong += 1
                    print(f"  WRONG {function.__name__}: {what}\n    what is left: {rest}")
    print(f"{proved} closed forms of docs/filter.md proved, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(__doc__)
        sys.exit(0 if sys.argv[1] in ("-h", "--help") else 2)
    sys.exit(main())
