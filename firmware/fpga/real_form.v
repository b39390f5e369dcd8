// Aligned samples of 16 elements to the numbers of solver.v: sums of products by lags, forward-backward as a real
// symmetric matrix, one power of two by its trace, diagonal loading. And the sum of all. A sample takes 123 clocks. See docs/fpga.md.
module real_form #(
    parameter TABLE = "real_form.hex",
    parameter ENTRIES = 63         // of it
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: no word is taken
    input wire [15:0] loading,     // delta/8, 2^-20
    input wire in_valid,
    output wire in_ready,
    input wire [31:0] in_word,     // {re, im} of element 0, ..., element 15; from -32767 on
    input wire in_end,             // with element 15: the line's last sample
    output wire out_valid,
    input wire out_ready,
    output wire [31:0] out_number,
    output wire [6:0] out_address,
    output wire out_last,          // of the sample
    output wire out_end,           // of the line
    output wire [4:0] out_exponent // constant in a sample; 0 without power
);
    // --- Words to one of two banks.
    reg [31:0] words [0:31];
    reg [1:0] full;
    reg full_end [0:1];
    reg in_bank, bank;
    reg [3:0] in_element;
    wire taken = in_valid && in_ready;
    wire fills = taken && &in_element;
    wire consumed;
    assign in_ready = enable && !full[in_bank];
    always @(posedge clock) begin
        if (taken) words[{in_bank, in_element}] <= in_word;
        if (taken) in_element <= in_element + 1'b1;
        if (fills) begin
            full_end[in_bank] <= in_end;
            in_bank <= !in_bank;
        end
        full <= (full | {fills && in_bank, fills && !in_bank}) & ~{consumed && bank, consumed && !bank};
        if (reset) begin
            full <= 0;
            {in_element, in_bank} <= 0;
        end
    end

    // --- Products of lag 0 to 7; as lag 8 the words themselves.
    reg [1:0] summed;              // banks of sums
    reg summed_end [0:1];
    reg sum_bank, read_bank, running;
    reg [3:0] lag, first;
    wire data = lag[3];
    wire last_product = first == (data ? 4'd15 : 4'd15 - lag);
    assign consumed = running && data && last_product;
    wire [3:0] second = data ? first : first + lag;
    always @(posedge clock) begin
        if (!running) begin
            running <= full[bank] && !summed[sum_bank] && !closing;
            {lag, first} <= 0;
        end else begin
            first <= last_product ? 4'd0 : first + 1'b1;
            if (last_product) lag <= lag + 1'b1;
            if (consumed) begin
                running <= 0;
                bank <= !bank;
            end
        end
        if (reset) {running, bank} <= 0;
    end

    reg [31:0] a_1, b_1, a_2, b_2;
    reg signed [31:0] rr_3, ii_3, ir_3, ri_3;
    reg signed [32:0] re_4, im_4;
    reg [65:0] products [0:15];
    reg signed [33:0] re_5, im_5;
    reg [36:0] re_all, im_all, re_ended, im_ended;   // the sum of all products of a lag
    reg signed [35:0] re_6, im_6;
    reg [3:0] first_1, first_2, first_3, first_4, first_5, first_6, lag_1, lag_2, lag_3, lag_4, lag_5, lag_6;
    reg [6:1] valid;
    wire signed [15:0] ar = a_2[31:16], ai = a_2[15:0], br = b_2[31:16], bi = b_2[15:0];
    reg [3:0] gone_4;
    reg goes_4;
    wire [65:0] past = goes_4 ? products[gone_4] : 66'd0;
    always @(posedge clock) begin
        a_1 <= words[{bank, second}];
        b_1 <= data ? {16'd1, 16'd0} : words[{bank, first}];
        {a_2, b_2} <= {a_1, b_1};
        rr_3 <= ar * br;
        ii_3 <= ai * bi;
        ir_3 <= ai * br;
        ri_3 <= ar * bi;
        re_4 <= {rr_3[31], rr_3} + {ii_3[31], ii_3};
        im_4 <= {ir_3[31], ir_3} - {ri_3[31], ri_3};
        gone_4 <= first_3 - 4'd9;
        goes_4 <= first_3 >= 9;
        products[first_4] <= {re_4, im_4};
        re_5 <= {re_4[32], re_4} - {past[65], past[65:33]};
        im_5 <= {im_4[32], im_4} - {past[32], past[32:0]};
        re_all <= (first_4 == 0 ? 37'd0 : re_all) + {{4{re_4[32]}}, re_4};
        im_all <= (first_4 == 0 ? 37'd0 : im_all) + {{4{im_4[32]}}, im_4};
        if (&first_5) {re_ended, im_ended} <= {re_all, im_all};
        re_6 <= (first_5 == 0 ? 36'd0 : re_6) + {{2{re_5[33]}}, re_5};
        im_6 <= (first_5 == 0 ? 36'd0 : im_6) + {{2{im_5[33]}}, im_5};
        {first_6, first_5, first_4, first_3, first_2, first_1} <= {first_5, first_4, first_3, first_2, first_1, first};
        {lag_6, lag_5, lag_4, lag_3, lag_2, lag_1} <= {lag_5, lag_4, lag_3, lag_2, lag_1, lag};
        valid <= {valid[5:1], running};
        if (reset) valid <= 0;
    end

    // --- A sum and its mirror image along the diagonal.
    reg [71:0] earlier [0:3];
    wire [3:0] mirror_5 = 4'd15 - lag_5 - first_5;
    reg [2:0] column_6;
    reg [1:0] mirror_6;
    reg middle_6, later_6;
    reg [36:0] re_7, im_7, re_8, im_8;
    reg [71:0] image_7;
    reg [5:0] place_7, place_8;
    reg write_7, write_8, ends_7, ends_8, last_8, power_7, power_8, top_8, bottom_8;
    (* no_rw_check *) reg [73:0] sums_f [0:127], sums_g [0:127];
    always @(posedge clock) begin
        {column_6, mirror_6} <= {first_5[2:0], mirror_5[1:0]};
        middle_6 <= mirror_5 == {1'b0, first_5[2:0]};
        later_6 <= mirror_5 <= {1'b0, first_5[2:0]};
        if (valid[6] && first_6[3] && !column_6[2]) earlier[column_6[1:0]] <= {re_6, im_6};
        image_7 <= lag_6[3] ? 72'd0 : middle_6 ? {re_6, im_6} : earlier[mirror_6];
        {re_7, im_7} <= {re_6[35], re_6, im_6[35], im_6};
        place_7 <= lag_6[3] ? {3'b100, column_6} : {1'b0, lag_6[2:0], mirror_6};
        write_7 <= valid[6] && first_6[3] && (lag_6[3] || later_6);
        power_7 <= valid[6] && first_6[3] && later_6 && lag_6 == 0;
        ends_7 <= valid[6] && lag_6[3] && (&first_6);
        if (ends_7) begin
            {re_7, im_7, image_7} <= {re_ended, im_ended, 72'd0};
            place_7 <= 40;
            write_7 <= 1;
        end
        re_8 <= re_7 + {image_7[71], image_7[71:36]};
        im_8 <= im_7 + {image_7[35], image_7[35:0]};
        {place_8, write_8, power_8} <= {place_7, write_7, power_7};
        {top_8, bottom_8} <= {&place_7[1:0], place_7[1:0] == 0};
        {last_8, ends_8} <= {ends_8, ends_7};
        if (write_8) begin
            sums_f[{sum_bank, place_8}] <= {re_8, im_8};
            sums_g[{sum_bank, place_8}] <= {re_8, im_8};
        end
        if (reset) {write_7, write_8, power_7, power_8, ends_7, ends_8, last_8} <= 0;
    end

    // --- The trace, and its leading zeros of 39 bits, during the other lags.
    reg [38:0] trace;
    reg [5:0] zeros;
    reg normal;
    reg [16:0] traces [0:1];
    reg [5:0] shifts [0:1];
    wire closing = |valid || write_7 || write_8;
    wire emitted;
    always @(posedge clock) begin
        if (power_8) begin
            trace <= (top_8 ? 39'd0 : trace) + {1'b0, re_8, 1'b0};
            zeros <= 0;
            normal <= bottom_8;
        end else if (normal && !trace[38] && zeros != 38) begin
            trace <= trace << 1;
            zeros <= zeros + 1'b1;
        end
        if (last_8) begin
            traces[sum_bank] <= trace[38:22];
            shifts[sum_bank] <= zeros;
            summed_end[sum_bank] <= full_end[!bank];
            sum_bank <= !sum_bank;
        end
        if (emitted) read_bank <= !read_bank;
        summed <= (summed | {last_8 && sum_bank, last_8 && !sum_bank}) & ~{emitted && read_bank, emitted && !read_bank};
        if (reset) begin
            summed <= 0;
            {sum_bank, read_bank, normal} <= 0;
        end
    end

    // --- The numbers of a sample, one after the other.
    localparam [5:0] LAST = ENTRIES[5:0] - 1'b1;
    localparam [31:0] STEERING = 32'h80000, GAIN = 32'h71c71c;
    reg [24:0] entries [0:ENTRIES-1];
    initial $readmemh(TABLE, entries);
    reg [5:0] next;
    reg issued;                    // all of them
    reg [8:1] moves;
    reg [8:1] last;
    wire room;
    wire issues = summed[read_bank] && !issued && room;
    assign emitted = moves[8] && last[8];

    reg [16:0] trace_read;
    reg [5:0] zeros_read;
    wire [4:0] half_zeros = zeros_read[5:1] + {4'd0, zeros_read[0]};
    reg [15:0] loading_read;
    reg [32:0] loaded_near, loaded;
    wire unused = &{entry_7[23], entry_7[21:9], loaded[10:0], shifted_7[12:0], zeros_read[5]};
    reg [4:0] exponent;

    reg [24:0] entry_1, entry_2, entry_3, entry_4, entry_5, entry_6, entry_7;
    reg [73:0] f_2, g_2, f_3, g_3;
    reg signed [37:0] value_4;
    reg signed [38:0] value_5;
    reg [5:0] shift_5;
    reg [2:0] shift_6;
    reg [44:0] shifted_6, shifted_7;
    reg [31:0] number_8;
    reg [6:0] address_8;
    wire imaginary = entry_3[19] ^ entry_3[20];
    wire signed [36:0] f = imaginary ? f_3[36:0] : f_3[73:37], g = imaginary ? g_3[36:0] : g_3[73:37];
    always @(posedge clock) begin
        trace_read <= traces[read_bank];
        zeros_read <= shifts[read_bank];
        loading_read <= loading;
        loaded_near <= trace_read * loading_read;
        loaded <= loaded_near;
        exponent <= trace_read[16] ? 5'd20 - half_zeros : 5'd0;
        moves <= {moves[7:1], issues};
        last <= {last[7:1], next == LAST};
        if (issues) begin
            next <= next == LAST ? 6'd0 : next + 1'b1;
            issued <= next == LAST;
        end
        entry_1 <= entries[next];
        {entry_7, entry_6, entry_5, entry_4, entry_3, entry_2} <= {entry_6, entry_5, entry_4, entry_3, entry_2, entry_1};
        f_2 <= sums_f[{read_bank, entry_1[12:7]}];
        g_2 <= sums_g[{read_bank, entry_1[18:13]}];
        {f_3, g_3} <= {f_2, g_2};
        value_4 <= entry_3[19] ? {f[36], f} - {g[36], g} : {f[36], f} + {g[36], g};
        value_5 <= entry_4[24] ? 39'd0 : entry_4[21] ? -{value_4[37], value_4} : {value_4[37], value_4};
        shift_5 <= entry_4[23] ? 6'd21 + {1'b0, half_zeros} : zeros_read;
        shifted_6 <= {{6{value_5[38]}}, value_5} << {shift_5[5:3], 3'd0};
        shift_6 <= shift_5[2:0];
        shifted_7 <= shifted_6 << shift_6;
        number_8 <= shifted_7[44:13] + (entry_7[22] ? {10'd0, loaded[32:11]}
            : !entry_7[24] ? 32'd0 : entry_7[8] ? GAIN : entry_7[7] ? STEERING : 32'd0);
        address_8 <= entry_7[6:0];
        if (emitted) issued <= 0;
        if (reset) {moves, next, issued} <= 0;
    end
    credits #(46) leaving (clock, reset, room, issues, moves[8],
        {summed_end[read_bank], exponent, last[8], address_8, number_8},
        {out_end, out_exponent, out_last, out_address, out_number}, out_valid, out_ready);
endmodule
