// For benches of a core with valid and ready on both sides: the clock, gaps of the input and of `enable`, and stalls of
// the output, in percent. A core that is not enabled must not take a word.
    always #5 clock = ~clock;

    function chance(input integer percent);
        chance = $unsigned($random) % 100 < percent;
    endfunction

    always @(negedge clock) begin
        out_ready = !chance(stalls);
        enable = !chance(gaps / 4);
    end

    always @(posedge clock) if (!enable && in_ready) errors = errors + 1;
