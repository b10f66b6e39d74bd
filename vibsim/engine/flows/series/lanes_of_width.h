/* The steps of WIDTH lanes, in one vector, from lane number `first` on. Included by lanes.c once for each width of the vectors of a
 * processor.
 */
#define JOINED_NAMES(a, b) a##b
#define NAMED_BY(a, b) JOINED_NAMES(a, b)
#define OF_WIDTH(name) NAMED_BY(name, WIDTH)
#define V OF_WIDTH(Vector)
#define Bits OF_WIDTH(Bits)
#define Row OF_WIDTH(Row)
#define AT(column) ((column) * (RUNS_AT_ONCE / WIDTH))
#define NUMBER(name) vector(l->name + first)
#define vector OF_WIDTH(vector)
#define magnitude OF_WIDTH(magnitude)
#define chosen OF_WIDTH(chosen)
#define below OF_WIDTH(below)
#define expand OF_WIDTH(expand)
#define exponent_of OF_WIDTH(exponent_of)
#define size_of OF_WIDTH(size_of)
#define longest_step OF_WIDTH(longest_step)
#define stays_clear OF_WIDTH(stays_clear)
#define end_of_step OF_WIDTH(end_of_step)

typedef double V VECTOR(WIDTH);
typedef long long Bits VECTOR(WIDTH);
typedef V Row[AT(COLUMNS)]; /* of the table, from lane number `first` on */

INLINE V vector(const double *x)
{
    V v;
    memcpy(&v, x, sizeof v);
    return v;
}

INLINE V magnitude(V x)
{
    return (V)((Bits)x & 0x7fffffffffffffffLL);
}

INLINE V chosen(Bits which, V one, V other)
{
    return (V)(((Bits)one & which) | ((Bits)other & ~which));
}

/* How far below zero. */
INLINE V below(V x)
{
    const V zero = {0};
    return chosen(x < zero, magnitude(x), zero);
}

/* Expand the motions, order by order as `advance_small` and `rotate` do; returns which angles are moderate. */
INLINE Bits expand(const Lanes *l, int first, const Real *inverse, const int p, Row *row)
{
    const V zero = {0}, k = NUMBER(k), c = NUMBER(c), unbalance = NUMBER(unbalance), drag = NUMBER(drag);
    const V inertia = NUMBER(inertia), mass = NUMBER(mass), mobility_far = NUMBER(mobility_far);
    const Bits moves = NUMBER(moves) != zero;
    V sine[SERIES], cosine[SERIES], a1[SERIES];
    V coupling, inverse_det, to_a1, to_w, cross, sw, pull = zero, previous = zero, w0;
    double sines[WIDTH], cosines[WIDTH];
    int n, i;
    for (i = 0; i < COLUMNS; i++)
        row[0][AT(i)] = NUMBER(start[i]);
    for (i = 0; i < WIDTH; i++)
        moderate_sine_cosine(l->start[ANGLE][first + i], &sines[i], &cosines[i]);
    sine[0] = vector(sines);
    cosine[0] = vector(cosines);
    w0 = row[0][AT(SPEED)];
    coupling = unbalance * sine[0];
    inverse_det = 1 / (mass * inertia - coupling * coupling);
    to_a1 = inertia * inverse_det;
    to_w = mass * inverse_det;
    cross = coupling * inverse_det;
    sw = sine[0] * w0;
    for (n = 0; n < p; n++) {
        const double by = inverse[n + 1];
        const V w = row[n][AT(SPEED)];
        V force = k * (row[n][AT(BODY)] - row[n][AT(FAR)]) + c * (row[n][AT(BODY_RATE)] - row[n][AT(FAR_RATE)]);
        V F, F_far, thrust, torque, tail, next;
        if (n == 0) {
            force = force + NUMBER(offset);
            F = (zero - force) + NUMBER(constant);
            F_far = (zero + force) + NUMBER(constant_far);
            cosine[1] = -sw;
            sine[1] = cosine[0] * w0;
            pull = unbalance * sine[1];
            tail = sine[1] * w0;
            torque = NUMBER(stall) - drag * w0;
            thrust = unbalance * tail;
        } else {
            const V scale = unbalance * (double)(n + 1), lean = cosine[0] * by;
            V cws = zero, tails = zero, backs = zero, odd_cws = zero, odd_tails = zero, odd_backs = zero, ahead, known, slope;
            F = zero - force;
            F_far = zero + force;
            for (i = 1; i + 1 < n; i += 2) {
                const V speed = row[n - i][AT(SPEED)], before = row[n - 1 - i][AT(SPEED)];
                cws += cosine[i] * speed;
                odd_cws += cosine[i + 1] * before;
                tails += sine[i + 1] * speed;
                odd_tails += sine[i + 2] * before;
                backs += sine[i + 1] * a1[n - 1 - i];
                odd_backs += sine[i + 2] * a1[n - 2 - i];
            }
            if (i < n) {
                cws += cosine[i] * row[n - i][AT(SPEED)];
                tails += sine[i + 1] * row[n - i][AT(SPEED)];
                backs += sine[i + 1] * a1[n - 1 - i];
            }
            ahead = ((cws + odd_cws) + cosine[n] * w0) * by;
            known = (tails + odd_tails) + ahead * w0;
            slope = sine[1] + lean * w0;
            cosine[n + 1] = -(sw * by);
            sine[n + 1] = ahead + lean * w;
            tail = known + slope * w;
            torque = (unbalance * (backs + odd_backs) - drag * w) + pull * previous;
            thrust = scale * known + scale * slope * w;
        }
        thrust = F + thrust;
        previous = a1[n] = to_a1 * thrust + cross * torque;
        next = to_w * by * torque + cross * by * thrust;
        sw = tail + sine[0] * next;
        row[n + 1][AT(BODY)] = row[n][AT(BODY_RATE)] * by;
        row[n + 1][AT(FAR)] = row[n][AT(FAR_RATE)] * by;
        row[n + 1][AT(ANGLE)] = w * by;
        row[n + 1][AT(BODY_RATE)] = previous * by;
        row[n + 1][AT(FAR_RATE)] = chosen(moves, F_far * mobility_far * by, zero);
        row[n + 1][AT(SPEED)] = next;
    }
    for (i = BODY; i <= ANGLE; i++) {
        row[p + 1][AT(i)] = row[p][AT(BODY_RATE + i)] * inverse[p + 1];
        row[p + 1][AT(BODY_RATE + i)] = zero;
    }
    return magnitude(row[0][AT(ANGLE)]) < LARGEST_ANGLE;
}

/* Its exponent, as `binary_exponent`; clears lanes of `regular` where it is no normal number. */
INLINE V exponent_of(V size, Bits *regular)
{
    const Bits biased = (Bits)size >> 52 & 0x7ffLL;
    *regular &= (biased != 0) & (biased != 0x7ffLL);
    return (V)(biased | 0x4330000000000000LL) - 4503599627370496.0 - 1022.0; /* a whole number in the last bits of 2^52 */
}

/* Of order n of one column, or of two. */
INLINE V size_of(const Row *row, int n, int one, int other)
{
    V size = magnitude(row[n][AT(one)]);
    if (other != one)
        size += magnitude(row[n][AT(other)]);
    return size;
}

/* As `longest_step` of a series that is one column, or two. */
INLINE V longest_step(const Row *row, int one, int other, int p, V tolerance, V longest, Bits *regular)
{
    V leading[LEADING_TERMS];
    int m, last;
    for (m = 0; m < LEADING_TERMS; m++)
        leading[m] = exponent_of(size_of(row, m, one, other), regular);
    for (last = p - 1; last <= p; last++) {
        const V following = exponent_of(size_of(row, last, one, other), regular);
        V best = (tolerance + (leading[0] - following)) / (double)last;
        for (m = 1; m < LEADING_TERMS; m++) {
            const V step = (tolerance + (leading[m] - following)) / (double)(last - m);
            best = chosen(step > best, step, best);
        }
        longest = chosen(best < longest, best, longest);
    }
    return longest;
}

/* Which lanes are sure to stay above zero on the whole step, and above the grazing margin or without a minimum, their known zeros divided
 * out. Sums of terms are those of the step; a known zero moves their orders by one.
 */
INLINE Bits stays_clear(const Watched *e, int first, const Row *row, int p, V h, V margin)
{
    const V zero = {0}, known = vector(e->known + first);
    const Bits shifted = known == 1;
    V factor[COLUMNS], power = h, start = vector(e->constant + first), linear = zero, square = zero;
    V sizes = magnitude(start), rest = zero, swing = zero, tail = zero, rounding, fall, low;
    int used[COLUMNS], count = 0, n, c;
    for (c = 0; c < COLUMNS; c++)
        if (e->used[c]) {
            factor[count] = vector(e->factor[c] + first);
            used[count++] = AT(c);
        }
    for (c = 0; c < count; c++) {
        const V part = factor[c] * row[0][used[c]];
        start += part;
        sizes += magnitude(part);
    }
    for (n = 1; n <= p + 1; n++) {
        V sum = zero, size = zero, term;
        for (c = 0; c < count; c++) {
            const V part = factor[c] * row[n][used[c]];
            sum += part;
            size += magnitude(part);
        }
        term = magnitude(sum) * power;
        sizes += size * power;
        if (n == 1)
            linear = sum * power;
        else if (n == 2)
            square = sum * power;
        else
            rest += term;
        swing += (double)n * term;
        if (n >= p - 1)
            tail += term;
        power = power * h;
    }
    rounding = SLACK * EPS * sizes;
    fall = rest + rounding + chosen(shifted, below(square), magnitude(square) + below(linear));
    low = chosen(shifted, linear, start) - fall;
    return ((known == zero) | shifted) & (low > tail) &
           ((vector(e->turns + first) == zero) | (low >= chosen(shifted, margin * h, margin)) | (2 * magnitude(linear) > swing + 2 * rounding));
}

/* All columns at `length`, as `dense_block` sums them, into the last row; the rate of the speed there. */
INLINE V end_of_step(Row *row, int p, V length)
{
    const V square = length * length;
    V rate = (double)p * row[p][AT(SPEED)];
    int c, n;
    for (c = 0; c < COLUMNS; c++) {
        V high = row[p + 1][AT(c)], low = row[p][AT(c)];
        for (n = p - 1; n > 0; n -= 2) {
            high = row[n][AT(c)] + high * square;
            low = row[n - 1][AT(c)] + low * square;
        }
        row[p + 2][AT(c)] = p % 2 == 0 ? low + length * high : row[0][AT(c)] + high * square + length * low;
    }
    for (n = p - 1; n > 0; n--)
        rate = rate * length + (double)n * row[n][AT(SPEED)];
    return rate;
}

static void OF_WIDTH(steps_of_)(Lanes *l, int first, const Real *inverse, int p)
{
    const V zero = {0}, tolerance = NUMBER(tolerance);
    Row *row = (Row *)((V *)l->table + first / WIDTH);
    Bits regular = expand(l, first, inverse, p, row), clear = {0};
    V longest = zero + 1000.0, length, rate;
    double exponents[WIDTH];
    int i;
    longest = longest_step(row, BODY_RATE, FAR_RATE, p, tolerance, longest, &regular);
    longest = longest_step(row, SPEED, SPEED, p, tolerance, longest, &regular);
    regular &= longest < 1000.0;
    memcpy(exponents, &longest, sizeof exponents);
    for (i = 0; i < WIDTH; i++)
        l->h[first + i] = power_of_two(exponents[i]);
    length = (NUMBER(t0) + NUMBER(h)) - NUMBER(t0);
    rate = end_of_step(row, p, length);
    for (i = 0; i < l->watched_count; i++)
        clear |= stays_clear(&l->watched[i], first, row, p, NUMBER(h), NUMBER(margin)) & 1LL << i;
    memcpy(l->length + first, &length, sizeof length);
    memcpy(l->spin_rate + first, &rate, sizeof rate);
    memcpy(l->regular + first, &regular, sizeof regular);
    memcpy(l->clear + first, &clear, sizeof clear);
}

#undef V
#undef Bits
#undef Row
#undef AT
#undef vector
#undef magnitude
#undef chosen
#undef below
#undef NUMBER
#undef expand
#undef exponent_of
#undef size_of
#undef longest_step
#undef stays_clear
#undef end_of_step
#undef OF_WIDTH
#undef NAMED_BY
#undef JOINED_NAMES
