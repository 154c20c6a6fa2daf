// Radix sort of records (key, value) by one digit of the key: records are cut into runs of run_length, and counts are
// ordered by digit, then run, so that their prefix sums are where each run's records of each digit go.
#push

fn digit_of(key: u32) -> u32 {
    return key >> push.shift & push.mask;
}
